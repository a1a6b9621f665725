"""Any message is read or refused, in bounded time."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.zigbee2mqtt import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

LINES = Path(__file__).with_name("models.jsonl").read_text(encoding="utf-8").splitlines()
ENTRIES: list[dict[str, Any]] = [json.loads(line)["entry"] for line in LINES]
PROPERTIES = ["state", "brightness", "color", "color_mode", "color_temp", "position", "action", "update", "lock_state"]

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["a/+", "\x00", "\ud800", "bridge", "9" * 400, 10**400, -1, 0, 1e308, "ON", "xy", "hs", "light"])
)
anything = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)
said = st.binary(max_size=60) | st.builds(lambda value: json.dumps(value).encode(), anything)
states = st.builds(
    lambda fields: json.dumps(fields).encode(),
    st.dictionaries(
        st.sampled_from(PROPERTIES),
        anything | st.dictionaries(st.sampled_from(["x", "y", "hue", "saturation", "state"]), scalars),
    ),
)
values = st.none() | st.booleans() | st.floats() | st.text(max_size=5) | st.tuples(st.floats(), st.floats())


def changed(value: object, draw: st.DataObject) -> object:
    """Put anything in the place of one thing, somewhere in *value*."""
    if isinstance(value, dict) and value and draw.draw(st.integers(0, 5)):
        key = draw.draw(st.sampled_from(sorted(value)))
        return {**value, key: changed(value[key], draw)}
    if isinstance(value, list) and value and draw.draw(st.integers(0, 5)):
        place = draw.draw(st.integers(0, len(value) - 1))
        return [*value[:place], changed(value[place], draw), *value[place + 1 :]]
    return draw.draw(anything)


def use(payload: bytes, heard: bytes, value: PlainValue, transition: float) -> None:
    """Take a list, let the parts of its devices hear something, and tell each of their capabilities something."""
    convention = Zigbee2Mqtt(Zigbee2MqttSettings())
    with suppress(WireError):
        convention.read_message("zigbee2mqtt/bridge/info", heard, retained=True)
    try:
        found = convention.read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    except WireError:
        return
    for one in found:
        for described in one.parts if isinstance(one, DeviceAnnounced) else ():
            for topic in described.codec.topics():
                described.codec.read(topic, heard, retained=False)
            for capability in described.part.capabilities:
                with suppress(RefusedError):
                    described.codec.write(capability.name, value, transition=transition)


@given(st.sampled_from(ENTRIES), st.data(), said | states, values, st.floats())
def test_any_change_to_a_real_entry_is_taken_or_refused(
    entry: dict[str, Any], draw: st.DataObject, heard: bytes, value: PlainValue, transition: float
) -> None:
    use(json.dumps([changed(entry, draw)]).encode(), heard, value, transition)


@pytest.mark.parametrize(
    "payload",
    [
        b"x" * 5_000_000,
        b"[" * 10_000 + b"]" * 10_000,
        b'[{"ieee_address": NaN}]',
        b'["\\ud800"]',
        b" " * (32 * 1024 * 1024) + b"[]",
        b"[" + b"{}," * 10_000 + b"{}]",
    ],
    ids=["junk", "deep", "NaN", "surrogate", "long", "many"],
)
def test_an_attack_is_refused_in_short_words(payload: bytes) -> None:
    with pytest.raises(WireError) as refused:
        Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=False)
    assert len(str(refused.value)) < 400


def test_a_device_with_ten_thousand_exposes_has_a_bounded_number_of_parts() -> None:
    many = [{"type": "numeric", "name": f"n{n}", "property": f"n{n}", "access": 1} for n in range(10_000)]
    lamps = [{"type": "light", "endpoint": f"l{n}", "features": many} for n in range(3)]
    entry = {**ENTRIES[0], "definition": {"exposes": [*lamps, *many]}}
    payload = json.dumps([entry]).encode()
    (found,) = Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    assert isinstance(found, DeviceAnnounced)
    assert len(found.parts) == 500


def test_names_are_cut_to_a_line() -> None:
    entry = {**ENTRIES[0], "friendly_name": "<b>\x1b[31m" + "n" * 400}
    payload = json.dumps([entry]).encode()
    (found,) = Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    assert isinstance(found, DeviceAnnounced)
    assert (found.name[:8], len(found.name)) == ("<b> [31m", 120)


def test_a_long_state_is_not_looked_at() -> None:
    payload = json.dumps([ENTRIES[0]]).encode()
    (found,) = Zigbee2Mqtt(Zigbee2MqttSettings()).read_message("zigbee2mqtt/bridge/devices", payload, retained=True)
    assert isinstance(found, DeviceAnnounced)
    part = found.parts[0]
    assert part.codec.read(part.codec.topics()[0], b'{"state":"ON"}' + b" " * 300_000, retained=False) == {}
