"""What strangers say is taken or refused; it never does anything else, and never takes long."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.tasmota import TasmotaDiscovery, TasmotaSettings
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

LINES = Path(__file__).with_name("devices.jsonl").read_text(encoding="utf-8").splitlines()
DEVICES: list[dict[str, Any]] = [json.loads(line) for line in LINES]
CONFIG = "tasmota/discovery/2462AB000011/config"
SENSORS = "tasmota/discovery/2462AB000011/sensors"
LAMP_KEYS = ["POWER", "POWER1", "Dimmer", "Color", "HSBColor", "CT", "White", "Scheme"]
KEYS = [*LAMP_KEYS, "FanSpeed", "Shutter1", "Switch1", "Wifi"]

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["%topic%", "#", "\x00", "\ud800", "9" * 400, 10**400, -1, 0, 1e308, "ON", "1,2,3"])
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
        st.sampled_from(KEYS),
        anything | st.dictionaries(st.sampled_from(["Position", "Direction", "Tilt", "Action", "Signal"]), scalars),
    ),
)
values = st.none() | st.booleans() | st.floats() | st.text(max_size=5) | st.tuples(st.floats(), st.floats())


def use(config: bytes, sensors: bytes, heard: bytes, value: PlainValue, transition: float) -> None:
    """Take both messages, let the parts hear something, and tell each of their capabilities something."""
    convention = TasmotaDiscovery(TasmotaSettings())
    with suppress(WireError):
        convention.read_message(SENSORS, sensors, retained=True)
    try:
        found = convention.read_message(CONFIG, config, retained=True)
    except WireError:
        return
    for one in found:
        for described in one.parts if isinstance(one, DeviceAnnounced) else ():
            for topic in described.codec.topics():
                described.codec.read(topic, heard, retained=False)
            for capability in described.part.capabilities:
                with suppress(RefusedError):
                    described.codec.write(capability.name, value, transition=transition)


@given(said, said, said)
def test_any_payload_is_read_or_refused(config: bytes, sensors: bytes, heard: bytes) -> None:
    use(config, sensors, heard, None, 0.0)


@given(
    st.sampled_from(DEVICES),
    st.dictionaries(st.sampled_from(sorted(DEVICES[0]["config"])), anything, max_size=3),
    said | st.builds(lambda value: json.dumps({"ver": 1, "sn": {"A": value}}).encode(), anything),
    said | states,
    values,
    st.floats(),
)
def test_any_change_to_a_real_device_is_taken_or_refused(
    device: dict[str, Any],
    change: dict[str, Any],
    sensors: bytes,
    heard: bytes,
    value: PlainValue,
    transition: float,
) -> None:
    fields = {**device["config"], "mac": "2462AB000011", **change}
    use(json.dumps(fields).encode(), sensors, heard, value, transition)


@given(st.sampled_from(DEVICES), said | states, values, st.floats())
def test_any_message_and_any_command_to_a_real_device_is_taken_or_refused(
    device: dict[str, Any], heard: bytes, value: PlainValue, transition: float
) -> None:
    fields = {**device["config"], "mac": "2462AB000011"}
    use(json.dumps(fields).encode(), json.dumps(device["sensors"]).encode(), heard, value, transition)


@pytest.mark.parametrize(
    "payload",
    [b"x" * 5_000_000, b'{"a":' * 10_000, b"[" * 9_999 + b"]" * 9_999, b'{"ver": NaN}', b'{"t": "\\ud800"}', b"[]"],
    ids=["junk", "open", "deep", "NaN", "surrogate", "list"],
)
@pytest.mark.parametrize("topic", [CONFIG, SENSORS])
def test_an_attack_is_refused_in_short_words(topic: str, payload: bytes) -> None:
    convention = TasmotaDiscovery(TasmotaSettings())
    with pytest.raises(WireError) as refused:
        convention.read_message(topic, payload, retained=False)
    assert convention.rejected == 1
    assert len(str(refused.value)) < 400


def test_names_are_cut_to_a_line() -> None:
    fields = {**DEVICES[0]["config"], "mac": "2462AB000011", "dn": "<b>\x1b[31m" + "n" * 200}
    (found,) = TasmotaDiscovery(TasmotaSettings()).read_message(CONFIG, json.dumps(fields).encode(), retained=True)
    assert isinstance(found, DeviceAnnounced)
    assert (found.name[:8], len(found.name)) == ("<b> [31m", 120)
