"""Which devices Apple Home has, and with which rights it commands them."""

import pytest
from tests.recorded_house import HOUSE, device, part

from homebot.config import parse_config
from homebot.errors import ConfigError
from homebot.feature import load
from homebot.features.homekit_bridge import FEATURE
from homebot.features.homekit_bridge.bridge import HomekitExports, clean_name
from homebot.features.homekit_bridge.settings import HomekitBridgeSettings

LOCK = next(one for one in HOUSE if one.name == "Front door lock")
LAMPS = [one.name for one in HOUSE if one.service_type == "light"]


def exports(*export: str, exclude: tuple[str, ...] = ()) -> HomekitExports:
    return HomekitExports(HomekitBridgeSettings(export=export, exclude=exclude))


def names(*export: str, exclude: tuple[str, ...] = ()) -> list[str]:
    chosen = exports(*export, exclude=exclude)
    return [one.name for one in HOUSE if chosen.of(one)[0] is not None]


def test_devices_are_chosen_by_types_rooms_and_names() -> None:
    assert names("light") == LAMPS
    assert names("light in hall", "climate") == ["Hall lamp two", "Bath heating"]
    assert names("light", exclude=("light in hall", 'name="Twin"')) == [
        name for name in LAMPS if name not in {"Hall lamp two", "Twin"}
    ]
    assert names("motion", "contact") == ["Hall motion", "Front door"]
    assert names() == []


def test_what_always_asks_needs_its_name() -> None:
    shown, problem = exports("lock", "lock in hall").of(LOCK)
    assert (shown, problem) == (
        None,
        "it is a door lock, so it is exported by its name alone: 'name=\"Front door lock\"'",
    )
    for query in ('name="Front door lock"', 'lock and name="Front door lock"', 'light or name="Front door lock"'):
        named = exports("light", query).of(LOCK)[0]
        assert named is not None
        assert named.scope == ("act: ordinary", 'act: name="front_door_lock"')
    for query in ('lock not name="Back door"', 'lock or name="Back door"'):
        assert exports(query).of(LOCK)[0] is None
    lamp = exports("light").of(HOUSE[0])[0]
    assert lamp is not None
    assert lamp.scope == ("act: ordinary",)


def test_names_have_only_the_signs_that_apple_home_takes() -> None:
    assert [clean_name(name) for name in ("bedroom_cover", "Anna's lamp (old)", "'", "Küche")] == [
        "bedroom cover",
        "Anna's lamp old",
        "Device",
        "Küche",
    ]


def test_a_plug_that_drives_a_boiler_needs_its_name_but_a_sensor_at_a_gate_does_not() -> None:
    boiler, gate = device("Boiler", part("plug", "on_off")), device("Gate", part("contact_sensor", "contact"))
    assert exports("plug").of(boiler)[0] is None
    assert exports("contact").of(gate)[0] is not None


def test_a_wrong_query_is_an_error_that_names_it() -> None:
    reader = load(FEATURE.tables["homekit_bridge"].reader)
    with pytest.raises(ConfigError, match="lihgt"):
        reader(parse_config({"homekit_bridge": {"export": ["lihgt"]}}, "homebot.toml"))
