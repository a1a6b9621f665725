"""Dialects take whatever comes over a wire, and any word that a broken device may say."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.house.devices import CoverMotor, SimulatedLamp, SimulatedThermostat
from homebot.house.dialect import SimulatedDeviceInfo, state_of
from homebot.house.family import dialects
from homebot.house.simulated_device import SimulatedDevice
from homebot.house.wire import as_object, device_orders, hardware_address, lamp_order, node_name
from homebot.mqtt.topics import validate_topic

pytestmark = pytest.mark.slow

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
KEYS = st.sampled_from(
    ["state", "brightness", "color_temp", "position", "turn", "temp", "method", "params", "src", "id", "on", "pos"]
)
MESSAGES = st.dictionaries(KEYS, VALUES | st.just("homebot") | st.just("Light.Set"), max_size=5).map(json.dumps)
WORDS = st.sampled_from(["on", "off", "open", "stop", "announce", "update", "10", "nan", "1e999", "-5", "LOCK"])
PAYLOADS = st.binary(max_size=40) | MESSAGES.map(str.encode) | WORDS.map(str.encode)
LEVELS = st.sampled_from(["Backlog", "Power1", "Dimmer", "CT", "ShutterPosition1", "Status", "state", "value", "é"])


@pytest.mark.parametrize("name", dialects())
@given(payload=PAYLOADS, level=LEVELS, said=st.text(max_size=12))
def test_no_message_and_no_word_is_too_odd(name: str, payload: bytes, level: str, said: str) -> None:
    """Commands that mean nothing give nothing; what is said can always be published."""
    dialect = dialects()[name]
    machines: tuple[SimulatedDevice, ...] = (SimulatedLamp("desk"), CoverMotor("blind"), SimulatedThermostat("heat"))
    for machine in machines:
        if machine.kind not in dialect.kinds:
            continue
        plate = SimulatedDeviceInfo("villa", machine.kind, machine.device_id, machine.service_type, "study")
        condition = state_of(machine, said)
        for topic_filter in dialect.filters(plate):
            topic = topic_filter.replace("+", level)
            for command in dialect.parse_command(plate, topic, payload):
                machine.handle_command(command, 1.0)
            for message in (
                *dialect.state_messages(plate, condition),
                *dialect.replies(plate, condition, topic, payload),
            ):
                validate_topic(message.topic)


@pytest.mark.parametrize(
    ("payload", "found"), [(b'{"a": 1}', {"a": 1}), (b"[1]", {}), (b"\xff", {}), (b"[" * 9999, {}), (b"{" * 99_999, {})]
)
def test_another_value_is_an_empty_object(payload: bytes, found: dict[str, object]) -> None:
    assert as_object(payload) == found


def test_a_message_to_a_lamp_may_hold_several_commands() -> None:
    """Off wins over a brightness; warmth comes first, so that it shines as it shall."""
    assert lamp_order(is_on=True, brightness=0.5, kelvin=2700.0) == ("2700 K", "0.5")
    assert lamp_order(is_on=False, brightness=0.5) == ("off",)
    assert lamp_order(is_on=True) == ("on",)
    assert lamp_order() == ()
    assert (device_orders("cover", action="OPEN"), device_orders("cover", action="ajar")) == (("open",), ())
    assert device_orders("contact", is_on=True, position=0.5, action="open", target=20.0) == ()


def test_devices_have_names_and_addresses_of_their_own() -> None:
    """Whatever they are called, and the same in every run."""
    desk = SimulatedDeviceInfo("villa", "lamp", "desk", "lights", "study")
    odd = SimulatedDeviceInfo("a/b", "lamp", "Küche 1", "lights", "kitchen")
    assert hardware_address(desk) == hardware_address(desk)
    assert hardware_address(desk) != hardware_address(odd)
    assert (len(hardware_address(desk, 16)), hardware_address(desk)[:2]) == (16, "02")
    assert node_name(desk) == "villa-desk"
    assert node_name(odd).isascii()
    assert not set(node_name(odd)) & set("/ +#")
