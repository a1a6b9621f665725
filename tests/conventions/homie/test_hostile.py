"""Any message and any value: only WireError from announcements, RefusedError from commands, nothing from states."""

import contextlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sizes import examples

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.homie import Homie, HomieSettings
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
JSON = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=4), max_leaves=5)
VALUES: st.SearchStrategy[PlainValue] = (
    st.none() | st.booleans() | st.floats() | st.text(max_size=10) | st.tuples(st.floats(), st.floats())
)
DATATYPES = st.sampled_from(["integer", "float", "boolean", "string", "enum", "color", "datetime", "duration", "json"])
FORMATS = st.sampled_from(["0:100", "1:255:0.5", "::", "-5:", "open,closed", "on,off", "rgb", "hsv,xyz"]) | st.text(
    max_size=9
)
IDS = st.sampled_from(
    ["state", "value", "position", "action", "color", "mode", "set-temperature", "lock", "speed", "tilt"]
)
TYPES = st.sampled_from(
    ["switch", "level", "color", "shutter", "lock", "valve", "thermostat", "fan", "button", "motion"]
)
PROPERTY = st.fixed_dictionaries(
    {"datatype": DATATYPES | JSON},
    optional={
        "format": FORMATS | JSON,
        "settable": st.booleans() | JSON,
        "retained": st.booleans(),
        "unit": st.text(max_size=4),
    },
)
NODE = st.fixed_dictionaries(
    {"properties": st.dictionaries(IDS, PROPERTY, max_size=5)},
    optional={"type": TYPES.map(lambda name: f"hc-smarthome/v2/cap/{name}") | JSON, "name": st.text(max_size=9) | JSON},
)
DOCUMENT = st.fixed_dictionaries(
    {"homie": st.just("5.0"), "nodes": st.dictionaries(IDS, NODE, max_size=4)},
    optional={"type": st.text(max_size=20), "root": IDS | JSON, "children": JSON, "name": st.text(max_size=200) | JSON},
)
SPOKEN = st.binary(max_size=30) | st.sampled_from(
    [b"true", b"50", b"rgb,1,2,3", b"hsv,1,2,3", b"xyz,0,0", b"open", b"nan"]
)


def use(device: DeviceAnnounced, payload: bytes, value: PlainValue, transition: float) -> None:
    for one in device.parts:
        for topic in one.codec.topics():
            one.codec.read(topic, payload, retained=False)
        for capability in one.part.capabilities:
            with contextlib.suppress(RefusedError):
                one.codec.write(capability.name, value, transition=transition)


@settings(max_examples=examples(60))
@given(DOCUMENT, SPOKEN, VALUES, st.floats())
def test_any_document_is_described_read_and_commanded(
    document: dict[str, object], payload: bytes, value: PlainValue, transition: float
) -> None:
    homie = Homie(HomieSettings())
    homie.read_message("homie/5/x/$state", b"ready", retained=True)
    with contextlib.suppress(WireError):
        for device in homie.read_message("homie/5/x/$description", json.dumps(document).encode(), retained=True):
            assert isinstance(device, DeviceAnnounced)
            use(device, payload, value, transition)


ATTRIBUTES = st.sampled_from(
    [
        *("$homie", "$state", "$nodes", "$name", "n/$properties", "n/$array", "n/$type", "n/p/$datatype"),
        *("n/p/$format", "n/p/$settable", "n/p/$unit", "n[]/$properties", "", "/", "n/p/q/$x"),
    ]
)
TEXTS = st.sampled_from(
    ["4.0.0", "ready", "n", "n[]", "p", "p,n,p", "0-99999", "boolean", "color", "true", "0:1"]
) | st.text(max_size=20)


@settings(max_examples=examples(60))
@given(st.lists(st.tuples(ATTRIBUTES, TEXTS), max_size=20), SPOKEN, VALUES, st.floats())
def test_any_attributes_are_survived(
    said: list[tuple[str, str]], payload: bytes, value: PlainValue, transition: float
) -> None:
    homie = Homie(HomieSettings())
    for attribute, text in said:
        with contextlib.suppress(WireError):
            for device in homie.read_message(f"homie/x/{attribute}", text.encode(errors="replace"), retained=True):
                if isinstance(device, DeviceAnnounced):
                    use(device, payload, value, transition)


@settings(max_examples=examples(60))
@given(
    st.binary(max_size=60),
    st.sampled_from(["homie/5/x/$description", "homie/5/x/$state", "homie/x/$nodes", "homie", "/"]),
)
def test_any_bytes_are_survived(payload: bytes, topic: str) -> None:
    with contextlib.suppress(WireError):
        Homie(HomieSettings()).read_message(topic, payload, retained=True)


def test_long_and_deep_messages_cost_little() -> None:
    homie = Homie(HomieSettings())
    for payload in (b"[" * 100_000, b"{" * 5_000_000, b'{"homie":"5.0","nodes":' + b'{"a":' * 10_000):
        for topic in ("homie/5/x/$description", "homie/x/$nodes"):
            with contextlib.suppress(WireError):
                assert homie.read_message(topic, payload, retained=True) == ()
