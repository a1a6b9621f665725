"""The values of a scene in words: what is shown can be given again."""

import pytest

from homebot.devices import Device, DevicePart, Endpoint, State
from homebot.devices.command_messages import Setting
from homebot.devices.value import PlainValue, Value
from homebot.features.scenes.scene_words import present_values, read_values, values_text
from homebot.gateways.announced.gateway_device import simple_part
from homebot.messages import Time

NOW = Time.from_seconds(100.0)


def device(service_type: str, **states: PlainValue) -> tuple[Device, DevicePart]:
    part = DevicePart(id="", part=simple_part(service_type, settable=tuple(states)), routes=())
    known = tuple(
        State(part="", capability=one, value=Value.of(value), since=NOW, told_at=NOW, live=True)
        for one, value in states.items()
    )
    endpoint = Endpoint(gateway="memory", key="it", address="it", command_address="it")
    fields = {"id": "it", "name": "It", "service_type": service_type, "endpoints": (endpoint,), "metadata": ()}
    times = {"first_seen": NOW, "last_seen": NOW, "expires": NOW}
    return Device(**fields, **times, freshness="fresh", parts=(part,), states=known), part  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("service_type", "states", "words"),
    [
        ("light", {"on_off": True, "level": 20.0}, "on, 20 %"),
        ("light", {"on_off": True, "level": 20.0, "color_temperature": 2700.0}, "on, 20 %, 2700 K"),
        ("light", {"on_off": True, "color": (240.0, 50.0)}, "on, color 240 50"),
        ("light", {"on_off": False, "level": 20.0, "color": (240.0, 50.0)}, "off"),
        ("window_covering", {"position": 30.0, "movement": "open"}, "position 30 %"),
        ("window_covering", {"movement": "closed"}, "movement closed"),
        ("fan", {"on_off": True, "fan_speed": 50.0}, "on, fan_speed 50 %"),
        ("thermostat", {"heating_setpoint": 21.5}, "heating_setpoint 21.5 °C"),
        ("thermostat", {"heating_setpoint": 21.5, "thermostat_mode": "off"}, "thermostat_mode off"),
        ("speaker", {"volume": 30.0}, "volume 30 %"),
    ],
)
def test_present_values_are_shown_in_words_that_mean_them(
    service_type: str, states: dict[str, PlainValue], words: str
) -> None:
    it, part = device(service_type, **states)
    values = present_values(it, part)
    assert values_text(tuple(map(Setting.of, values, values.values()))) == words
    assert read_values(words, it, part, "It") == values


def test_a_lamp_that_reports_white_and_a_colour_is_saved_with_the_newer() -> None:
    it, part = device("light", on_off=True, color=(240.0, 50.0), color_temperature=2700.0)
    later = Time.from_seconds(200.0)
    states = tuple(one.model_copy(update={"since": later}) if one.capability == "color" else one for one in it.states)
    assert present_values(it.model_copy(update={"states": states}), part) == {"on_off": True, "color": (240.0, 50.0)}


def test_a_cover_on_its_way_is_not_saved_by_its_motion() -> None:
    assert present_values(*device("window_covering", movement="opening")) == {}
