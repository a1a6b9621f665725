"""Any published part is read back with its capabilities, states and commands."""

import json
import math
import os
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import DescribedPart
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.exposure import ExposedDevice
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homeassistant.formats.publisher import HomeAssistantPublisher

TOLD = {
    "lock": ("locked", "unlocked"),
    "movement": ("open", "closed", "stopped"),
    "valve": ("open", "closed", "stopped"),
    "vacuum": ("cleaning", "paused", "idle", "returning", "spot"),
    "mower": ("mowing", "paused", "docked"),
    "alarm": ("disarmed", "armed_home", "armed_away", "triggered"),
}
SAID = {"alarm": ("disarmed", "armed_home", "pending"), "preset_mode": ("boost",), "valve": ("closed",)}
TEXTS = {
    "thermostat_mode": ("off", "heat", "auto"),
    "thermostat_action": ("off", "heating", "idle"),
    "water_heater_mode": ("off", "eco"),
    "preset_mode": ("none", "boost"),
}
SINGLES = ("on_off", "number", "option", "text", "push")
"""Components of single capabilities."""
DERIVED = frozenset({"movement", "valve", "on_off", "fan_mode", "update_available"})
"""Values that Home Assistant derives from a position or a mode."""


def capability(name: str, *, readable: bool, settable: bool) -> Capability:
    known = CAPABILITIES[name]
    options = TEXTS.get(name, ("a", "b")) if known.kind == "text" and not known.options else ()
    options = () if name in {"alarm", "scan", "text", "value", "place", "version", "raw"} else options
    bounds = (5.0, 30.0) if name.endswith("setpoint") else ()
    return Capability(name=name, readable=readable or not settable, settable=settable, options=options, bounds=bounds)


capabilities = st.builds(
    capability, st.sampled_from(sorted(CAPABILITIES)), readable=st.booleans(), settable=st.booleans()
)
parts = st.builds(
    lambda service_type, of, tag: Part(id="p", service_type=service_type, tag=tag, capabilities=tuple(of)),
    st.sampled_from(sorted(DEVICE_TYPES)),
    st.lists(capabilities, min_size=1, max_size=8, unique_by=lambda one: one.name),
    st.sampled_from(["", "garage", "blind", "window", "dehumidifier"]),
)


def whole(service_type: str, *names: str) -> Part:
    settable = {"local_temperature", "thermostat_action", "power", "battery", "humidity", "running"}
    of = tuple(capability(name, readable=True, settable=name not in settable) for name in names)
    return Part(id="p", service_type=service_type, capabilities=of)


CHARGED = Part(
    id="p",
    service_type="robotic_vacuum_cleaner",
    capabilities=tuple(capability(name, readable=True, settable=True) for name in ("battery", "vacuum")),
)
"""A cleaner with a settable battery, which Home Assistant does not have."""

LAMP = whole("light", "on_off", "level", "color", "color_temperature", "effect", "power")
WHOLE = (
    (LAMP, "light"),
    (whole("door_lock", "lock"), "lock"),
    (whole("window_covering", "movement", "position", "tilt"), "cover"),
    (whole("closure", "movement"), "cover"),
    (whole("fan", "on_off", "fan_speed", "preset_mode", "oscillation", "direction"), "fan"),
    (whole("water_valve", "valve", "position"), "valve"),
    (whole("thermostat", "thermostat_mode", "heating_setpoint", "local_temperature", "thermostat_action"), "climate"),
    (whole("water_heater", "water_heater_mode", "heating_setpoint", "local_temperature"), "water_heater"),
    (whole("x_humidifier", "on_off", "humidity_setpoint", "humidity", "humidifier_mode"), "humidifier"),
    (whole("robotic_vacuum_cleaner", "vacuum", "fan_mode", "battery", "locate"), "vacuum"),
    (whole("x_lawn_mower", "mower"), "lawn_mower"),
    (whole("x_alarm_panel", "alarm"), "alarm_control_panel"),
    (whole("siren", "on_off", "siren_tone", "volume"), "siren"),
)


SINGLE = tuple(whole("x_robot", name) for name in ("on_off", "running", "battery", "level", "option", "locate"))


class Way:
    """An exposed device with one part, and its entities in Home Assistant."""

    def __init__(self, part: Part) -> None:
        self.part = part
        self.ours = HomeAssistantPublisher("homeassistant", "hub", "homebot/hub/status")
        self.offer = ExposedDevice(id="thing", name="Thing", parts=(part,))
        self.configs = self.ours.publications(self.offer)
        self.back = [
            (one.topic.split("/")[1], read) for one in self.configs for read in understood(one.topic, one.payload)
        ]

    @property
    def components(self) -> list[str]:
        return [component for component, _ in self.back]

    def told(self, name: str, value: PlainValue) -> Iterator[dict[str, PlainValue]]:
        """Return the commands after setting *name* of any entity to *value* in Home Assistant."""
        for _, read in self.back:
            if any(one.name == name and one.settable for one in read.part.capabilities):
                with suppress(RefusedError):
                    yield {
                        command.capability: command.value.plain()
                        for publication in read.codec.write(name, value)
                        for command in self.ours.read_command(publication.topic, publication.payload)
                    }

    def said(self, name: str, value: PlainValue) -> dict[str, PlainValue]:
        """Return the readings of Home Assistant after the part reports *value*."""
        known = {("p", name): value}
        if name in {"color", "color_temperature", "level"}:
            known["p", "on_off"] = True
        found: dict[str, PlainValue] = {}
        for state in self.ours.states(self.offer, known, {("p", name)}):
            for _, read in self.back:
                found.update(read.codec.read(state.topic, state.payload, retained=False))
        return found


HOME_ASSISTANT = Path(
    os.environ.get("HOMEASSISTANT_PYTHON", Path(__file__).parents[4] / ".venv-bench-ha" / "bin" / "python")
)
SCHEMAS = Path(__file__).with_name("home_assistant_schemas.py")


def understood(topic: str, payload: bytes) -> list[DescribedPart]:
    heard = device_in(HomeAssistantDiscovery(HomeAssistantSettings()).read_message(topic, payload, retained=True))
    assert len(heard.parts) == 1, payload
    return list(heard.parts)


def a_value(one: Capability, words: dict[str, tuple[str, ...]]) -> PlainValue:
    match CAPABILITIES[one.name].kind:
        case "bool":
            return True
        case "number":
            return 4000.0 if one.name == "color_temperature" else min([20.0, *CAPABILITIES[one.name].bounds[1:]])
        case "numbers":
            return (120.0, 50.0)
        case _:
            options = words.get(one.name) or one.options or CAPABILITIES[one.name].options or ("x",)
            return options[0]


def is_alike(one: PlainValue, other: PlainValue) -> bool:
    if isinstance(one, tuple) and isinstance(other, tuple):
        return all(map(is_alike, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=0.005)
    return one == other


@pytest.mark.parametrize(("part", "component"), WHOLE)
def test_capabilities_of_one_entity_are_published_together(part: Part, component: str) -> None:
    way = Way(part)
    assert way.components[0] == component
    names = {one.name for one in part.capabilities}
    apart = names & {"power", "battery"}
    assert way.components[1:] == ["sensor"] * len(apart)
    there = way.back[0][1].part
    assert there.service_type == part.service_type
    names -= apart
    assert names <= {one.name for one in there.capabilities} <= names | DERIVED


def check_orders(part: Part) -> None:
    """Both sides have the same commands."""
    way = Way(part)
    settable = {one.name: one for one in part.capabilities if one.settable}
    for _, read in way.back:
        for one in read.part.capabilities:
            for ordered in way.told(one.name, a_value(one, TOLD)) if one.settable else ():
                assert ordered, one.name
                assert ordered.keys() <= settable.keys()
    for name, one in settable.items():
        value = a_value(one, TOLD)
        orders = [ordered[name] for known in {name, *SINGLES} for ordered in way.told(known, value) if name in ordered]
        if name == "valve" and not orders:  # one that tells its position is opened by that
            orders = [value for ordered in way.told(name, value) if ordered == {"position": 100.0}]
        assert orders or name == "color", (name, way.components)
        assert all(is_alike(value, ordered) for ordered in orders), (name, value, orders)


def check_states(part: Part) -> None:
    """Reports of the part are read in Home Assistant."""
    way = Way(part)
    for one in part.capabilities:
        if not one.readable or one.name in {"color", "image", "push", "scene", "locate"}:
            continue
        value = a_value(one, SAID)
        heard = way.said(one.name, value)
        same = [name for name, told in heard.items() if is_alike(value, told)]
        assert same, (one.name, value, heard, way.components)


@given(parts)
@example(LAMP)
@example(CHARGED)
def test_the_commands_of_an_entity_are_those_of_the_part(part: Part) -> None:
    check_orders(part)


@given(parts)
@example(LAMP)
@example(CHARGED)
def test_published_states_are_read_by_an_entity(part: Part) -> None:
    check_states(part)


@pytest.mark.parametrize("part", [*(part for part, _ in WHOLE), *SINGLE])
def test_an_entity_is_commanded_and_read(part: Part) -> None:
    check_orders(part)
    check_states(part)


@pytest.mark.parametrize("word", ["jammed", "locking", "open"])
def test_a_lock_takes_no_state_that_is_only_reported(word: str) -> None:
    """Named in the field: ``jammed`` could be chosen from a list."""
    way = Way(Part(id="p", service_type="door_lock", capabilities=(Capability(name="lock", settable=True),)))
    (config,) = way.configs
    fields = json.loads(config.payload)
    assert config.topic.split("/")[1] == "lock"
    assert "options" not in fields
    assert way.ours.read_command(fields["command_topic"], word.encode()) == ()
    assert way.said("lock", "jammed") == {"lock": "jammed"}


@given(parts)
def test_withdrawing_clears_all_that_was_kept(part: Part) -> None:
    way = Way(part)
    known = {("p", one.name): a_value(one, SAID) for one in part.capabilities if one.readable}
    kept = {one.topic for one in (*way.configs, *way.ours.states(way.offer, known, known)) if one.retain}
    gone = way.ours.publications(way.offer.model_copy(update={"is_withdrawn": True}))
    assert kept <= {one.topic for one in gone}
    assert all(one.retain and not one.payload for one in gone)
    for one in part.capabilities:
        assert way.ours.states(way.offer, known, {("p", one.name)}) == ()


@pytest.mark.system
@pytest.mark.skipif(not HOME_ASSISTANT.exists(), reason="no Home Assistant; `make bench` installs one")
def test_home_assistants_own_schemas_take_every_config() -> None:
    lines: dict[str, None] = {}

    @settings(max_examples=1000, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(parts)
    def collect(part: Part) -> None:
        for one in Way(part).configs:
            lines[json.dumps([one.topic.split("/")[1], json.loads(one.payload)])] = None

    collect()
    for part, _ in WHOLE:
        collect.hypothesis.inner_test(part)  # type: ignore[attr-defined]
    program = [str(HOME_ASSISTANT), str(SCHEMAS)]
    answer = subprocess.run(program, input="\n".join(lines), capture_output=True, text=True, check=True)
    assert len(lines) > 100
    assert answer.stdout == ""
