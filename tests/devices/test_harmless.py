"""What is harmless to whoever asks, and what words, classes, models and units reveal in fifteen languages."""

import json
from pathlib import Path

import pytest
from tests.call_counts import calls
from tests.devices.handles.conftest import device, part

from homebot.devices.always_ask import always_asks, why_it_asks
from homebot.devices.client_rights import APP_RIGHTS, LOCAL_RIGHTS, ClientRights
from homebot.devices.device import Device, Fact, KeyValue
from homebot.devices.device_types import spoken_type
from homebot.devices.harmless import why_not_harmless
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.devices.words import ALL_THAT_ASK, matching_words
from homebot.messages import Time
from homebot.words.rights import read_scope

LOADS: dict[str, dict[str, list[str]]] = json.loads(
    Path(__file__).with_name("loads_by_name.json").read_text(encoding="utf-8")
)
HARMLESS = read_scope(["act: harmless"])
MOVED = [("switch", "on_off"), ("plug", "on_off"), ("window_covering", "movement"), ("x_setting", "push")]


def of_model(model: str, *parts: tuple[str, str], name: str = "0x00158d0001", category: str = "") -> Device:
    made = [part(kind, can, part_id=f"{number}", category=category) for number, (kind, can) in enumerate(parts)]
    return device(name, *made).model_copy(update={"metadata": (KeyValue(key="model", value=model),)})


def tagged(one: Device, tag: str, convention: str = "owner") -> Device:
    fact = Fact(name="tag", value=tag, gateway="", convention=convention, key="", said_at=Time.from_seconds(0))
    return one.model_copy(update={"tags": (tag,), "facts": (fact,)})


def is_harmless(one: Device, number: int = 0, **settings: PlainValue) -> bool:
    return not why_not_harmless(one, one.parts[number], settings)


def may(rights: ClientRights, one: Device, number: int = 0) -> bool:
    asks = always_asks(one, one.parts[number])
    return rights.may_command(one, one.parts[number], asks=asks, is_harmless=is_harmless(one, number))


@pytest.mark.parametrize("language", LOADS)
def test_in_fifteen_languages_what_burns_floods_or_opens_asks_everybody(language: str) -> None:
    for name in LOADS[language]["asks"]:
        for kind, capability in MOVED:
            one = device("0x1", part(kind, capability, name=name))
            assert [may(rights, one) for rights in (APP_RIGHTS, LOCAL_RIGHTS, HARMLESS)] == [False] * 3, (name, kind)


@pytest.mark.parametrize("language", LOADS)
def test_a_relay_of_another_name_asks_all_but_the_owners_apps(language: str) -> None:
    """Its name may say anything in a language that no table has."""
    for name in LOADS[language]["free"]:
        for kind in ("switch", "plug"):
            one = device("0x1", part(kind, "on_off", name=name))
            assert [may(rights, one) for rights in (APP_RIGHTS, LOCAL_RIGHTS, HARMLESS)] == [True, False, False], name


@pytest.mark.parametrize("language", LOADS)
def test_no_lamp_asks_whatever_its_name(language: str) -> None:
    for name in (*LOADS[language]["asks"], *LOADS[language]["free"]):
        one = device(name, part("light", "on_off", "level", "effect", name=name))
        assert [may(rights, one) for rights in (APP_RIGHTS, LOCAL_RIGHTS, HARMLESS)] == [True] * 3, name


@pytest.mark.parametrize(
    "one",
    [
        device("x", part("fan", "fan_speed")),
        device("x", part("speaker", "volume")),
        device("x", part("video_player", "on_off")),
        device("x", part("x_humidifier", "humidity_setpoint")),
        device("x", part("window_covering", "movement", tag="blind")),
        device("x", part("window_covering", "movement", tag="mdi:roller-shade")),
        device("x", part("window_covering", "movement", advertised="blinds")),
        device("Rollladen Bad", part("window_covering", "movement")),
        of_model("Curtain motor", ("window_covering", "movement")),
        device("x", part("switch", "on_off", tag="mdi:floor-lamp")),
        of_model("Solar LED house number light", ("switch", "on_off")),
        of_model("x", ("light", "on_off"), ("x_setting", "option"), ("x_scene", "scene")),
        tagged(device("Coffee", part("plug", "on_off")), "Harmless"),
    ],
)
def test_what_says_that_it_can_hurt_nobody_is_harmless(one: Device) -> None:
    assert [is_harmless(one, number) for number in range(len(one.parts))] == [True] * len(one.parts)


@pytest.mark.parametrize(
    ("one", "reason"),
    [
        (device("Freezer", part("plug", "on_off")), "nothing but its name says what this plug turns on"),
        (device("Lamp", part("switch", "on_off")), "nothing but its name says what this switch turns on"),
        (device("x", part("switch", "on_off", tag="mdi:alarm-light")), "nothing but its name"),
        (device("x", part("window_covering", "movement")), "nothing says that it is a blind"),
        (device("Garaažiuks", part("window_covering", "movement")), "nothing says that it is a blind"),
        (of_model("Curtain motor or window pusher", ("window_covering", "movement")), "says 'window pusher'"),
        (device("x", part("window_covering", "movement", name="Shop shutter")), "says 'shop shutter'"),
        *(
            (device("x", part(kind, "on_off")), f"it is {spoken_type(kind)}")
            for kind in ("siren", "pump", "x_unknown", "x_lawn_mower", "robotic_vacuum_cleaner", "camera", "x_setting")
        ),
        (device("x", part("x_scene", "scene", name="Evening")), "it is a scene"),
        (device("x", part("x_setting", "push", name="Emergency stop")), "it is a setting"),
        (device("x", part("x_setting", "number", name="Charge limit")), "it is a setting"),
        (of_model("Boiler thermostat", ("thermostat", "heating_setpoint")), "says 'boiler'"),
        (of_model("Fan with valve", ("fan", "fan_speed")), "says 'valve'"),
        (device("x", part("door_lock", "lock")), "it is a door lock"),
    ],
)
def test_everything_else_says_why_it_is_not(one: Device, reason: str) -> None:
    assert reason in why_not_harmless(one, one.parts[0])


def test_the_settings_of_a_lamp_that_is_more_than_a_lamp_are_not_harmless() -> None:
    """A smoke alarm with a lamp can be hushed; one of a siren sounds."""
    alarm = device("x", part("light", "on_off"), part("smoke_co_alarm", reads=["smoke"]), part("x_setting", "on_off"))
    assert [is_harmless(alarm, number) for number in (0, 2)] == [True, False]
    siren = device("x", part("light", "on_off"), part("x_setting", "option", name="Siren"), part("x_setting", "text"))
    assert [is_harmless(siren, number) for number in range(3)] == [True, False, False]


@pytest.mark.parametrize("capability", ["heating_setpoint", "cooling_setpoint"])
@pytest.mark.parametrize("kind", ["thermostat", "room_air_conditioner"])
def test_a_thermostat_is_harmless_from_5_to_28_degrees(kind: str, capability: str) -> None:
    one = device("x", part(kind, capability, "thermostat_mode"))
    allowed = [not why_not_harmless(one, one.parts[0], {capability: value}) for value in (5.0, 28.0, 4.5, 28.5)]
    assert allowed == [True, True, False, False]
    assert is_harmless(one, thermostat_mode="off")
    assert "heating_setpoint 30 is not within 5 to 28 °C" in why_not_harmless(
        one, one.parts[0], {"heating_setpoint": 30.0}
    )


def test_the_word_harmless_counts_from_the_owner_alone_and_not_for_a_lock() -> None:
    relay = device("x", part("switch", "on_off"))
    assert [is_harmless(tagged(relay, "harmless", convention)) for convention in ("homeassistant", "owner")] == [
        False,
        True,
    ]
    assert not is_harmless(tagged(device("x", part("door_lock", "lock")), "harmless"))
    assert not is_harmless(tagged(device("Gate", part("switch", "on_off")), "harmless"))


def test_what_the_owner_approved_is_harmless_unless_it_always_asks() -> None:
    def approved(one: Device) -> Device:
        only = one.parts[0]
        routes = tuple(route.model_copy(update={"approved": "1"}) for route in only.routes)
        return one.model_copy(update={"parts": (only.model_copy(update={"routes": routes}),)})

    assert is_harmless(approved(device("x", part("switch", "on_off"))))
    assert not is_harmless(approved(device("x", part("door_lock", "lock"))))


ENSYSTEC = "Leak protect controller with Zigbee module"
"""Names and models of zigbee-herdsman-converters 26.112."""


@pytest.mark.parametrize(
    ("one", "says"),
    [
        # QOTO QT-05M, which opens by a percentage.
        (of_model("Solar powered garden watering timer", ("x_setting", "number"), category="config"), "'watering'"),
        (of_model(ENSYSTEC, ("switch", "on_off")), "'leak protect'"),
        (device("0x1", part("x_setting", "push", name="Force open 6", category="config")), "'force open'"),
        (device("0x1", part("x_setting", "on_off", name="Ring to open")), "'ring to open'"),
        (device("0x1", part("x_setting", "option", name="Lock mode", category="config")), "'lock mode'"),
        (device("0x1", part("x_setting", "on_off", name="Button lock mode", category="config")), ""),
        (device("0x1", part("x_setting", "on_off", name="Window open force")), ""),
        (of_model("Matrix intercom auto opener", ("x_setting", "option"), category="config"), "'auto opener'"),
        (of_model("Drivent window drive", ("window_covering", "movement")), "'window drive'"),
        (of_model("Curtain motor or window pusher", ("window_covering", "movement")), ""),
        (device("0x1", part("switch", "on_off", tag="mdi:pipe-valve")), "the icon 'mdi:pipe-valve' says 'valve'"),
        (device("0x1", part("window_covering", "movement", tag="mdi:gate-open")), "says 'gate'"),
        (device("0x1", part("x_setting", "push", tag="mdi:door-open")), "says 'door open'"),
        (device("0x1", part("switch", "on_off", tag="mdi:lock")), ""),
        (device("0x1", part("switch", "on_off", tag="mdi:lightbulb")), ""),
        (device("0x1", part("x_setting", "on_off", name="Alert", tag="mdi:door-open")), ""),
        (device("0x1", part("x_setting", "option", name="Program", tag="mdi:sprinkler")), "says 'sprinkler'"),
        (device("0x1", part("switch", "on_off", name="Detection", tag="mdi:pipe-valve", category="config")), ""),
    ],
)
def test_a_model_class_or_icon_tells_the_load_of_settings_too(one: Device, says: str) -> None:
    why = why_it_asks(one, one.parts[0])
    assert says in why if says else not why


@pytest.mark.parametrize(
    ("unit", "category", "asks"), [("L", "", True), ("m³/h", "", True), ("L", "config", False), ("kWh", "", False)]
)
def test_a_number_that_pours_always_asks(unit: str, category: str, *, asks: bool) -> None:
    volume = Capability(name="number", settable=True, unit=unit)
    one = device("0x1", part("x_setting", name="Amount", category=category, capabilities=(volume,)))
    assert always_asks(one, one.parts[0]) is asks


def test_the_settings_of_a_radiator_or_a_gas_alarm_do_not_ask_by_their_model() -> None:
    for model, kind in (("Radiator valve with thermostat", "thermostat"), ("Gas sensor", "smoke_co_alarm")):
        one = of_model(model, (kind, "heating_setpoint"), ("x_setting", "number"))
        assert not always_asks(one, one.parts[1]), model


def test_a_name_of_words_seen_before_is_searched_with_few_calls() -> None:
    """Each announcement of a house is: names repeat few words, and ``lamp`` alone is no heat lamp."""
    matching_words("Lamp 1", ALL_THAT_ASK)

    assert calls(lambda: [matching_words(f"Lamp {number}", ALL_THAT_ASK) for number in range(2, 102)]) < 2500
    assert matching_words("Heat lamp 7", ALL_THAT_ASK) == "heat lamp"
