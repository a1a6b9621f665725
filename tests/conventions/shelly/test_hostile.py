"""Whatever strangers say: WireError from take, RefusedError from write, nothing from read."""

import contextlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sizes import examples

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.shelly import Shelly, ShellySettings
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

KEYS = st.sampled_from(
    [
        "id",
        "mac",
        "model",
        "mode",
        "src",
        "result",
        "params",
        "method",
        "events",
        "event",
        "component",
        "sys",
        "device",
        "switch:0",
        "cover:0",
        "rgbcct:0",
        "input:0",
        "em:0",
        "thermostat:0",
        "number:200",
        "bthomesensor:200",
        "blutrv:200",
        "output",
        "brightness",
        "rgb",
        "ct",
        "state",
        "value",
        "temperature",
        "tC",
        "aenergy",
        "total",
        "obj_id",
        "type",
    ]
)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
JSON = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=6), max_leaves=8
)
PAYLOADS = st.binary(max_size=60) | JSON.map(lambda one: json.dumps(one).encode())
TOPICS = st.sampled_from(
    [
        "shellies/announce",
        "shellies/a/announce",
        "shellies/a/online",
        "shellies/a/relay/0",
        "shellies/a/sensor/gas",
        "shellies/a/color/1/status",
        "shellies/a/status",
        "shellies//relay/0",
        "shellies/a/relay/99",
        "a/online",
        "a/events/rpc",
        "homebot/a/rpc",
        "homebot/rpc",
        "/online",
        "/events/rpc",
        "homebot//rpc",
    ]
)
VALUES: st.SearchStrategy[PlainValue] = SCALARS.filter(
    lambda one: not isinstance(one, int) or isinstance(one, bool)
) | st.tuples(st.floats(), st.floats())


def use(device: DeviceAnnounced, payload: bytes, value: PlainValue, transition: float) -> None:
    for one in device.parts:
        for topic in one.codec.topics():
            one.codec.read(topic, payload, retained=False)
        for capability in one.part.capabilities:
            with contextlib.suppress(RefusedError):
                one.codec.write(capability.name, value, transition=transition)


@settings(max_examples=examples(40))
@given(st.lists(st.tuples(TOPICS, PAYLOADS), max_size=8), PAYLOADS, VALUES, st.floats())
def test_anything_said_is_survived(
    said: list[tuple[str, bytes]], payload: bytes, value: PlainValue, transition: float
) -> None:
    shelly = Shelly(ShellySettings())
    for topic, one in said:
        try:
            heard = shelly.read_message(topic, one, retained=False)
        except WireError:
            continue
        for device in heard:
            if isinstance(device, DeviceAnnounced):
                use(device, payload, value, transition)


COMPONENTS = st.dictionaries(
    st.sampled_from(
        ["switch", "cover", "light", "cct", "rgb", "rgbw", "rgbcct", "input", "pm1", "em", "em1", "smoke"]
    ).map(lambda kind: f"{kind}:0")
    | st.sampled_from(
        ["thermostat:0", "number:200", "enum:200", "text:200", "boolean:200", "button:200", "blutrv:200"]
    ),
    st.dictionaries(KEYS, JSON, max_size=5),
    min_size=1,
    max_size=5,
)


@settings(max_examples=examples(40))
@given(COMPONENTS, COMPONENTS, JSON, VALUES, st.floats())
def test_any_component_is_described_read_and_told(
    status: dict[str, object], config: dict[str, object], said: object, value: PlainValue, transition: float
) -> None:
    shelly = Shelly(ShellySettings())
    for result in (
        {"id": "x", "mac": "A8032ABE54DC"},
        {"sys": {"device": {}}, **config},
        {"sys": {"mac": "A8"}, **status},
    ):
        try:
            heard = shelly.read_message(
                "homebot/x/rpc", json.dumps({"src": "x", "result": result}).encode(), retained=False
            )
        except WireError:
            continue
        for device in heard:
            assert isinstance(device, DeviceAnnounced)
            for key in status:
                payload = json.dumps({"params": {key: said}, "result": {key: said}}).encode()
                use(device, payload, value, transition)


def test_long_and_deep_messages_cost_little() -> None:
    shelly = Shelly(ShellySettings())
    for payload in (b"[" * 100_000, b"{" * 5_000_000, b'{"src":"x","result":' + b'{"a":' * 10_000):
        for topic in ("homebot/x/rpc", "x/events/rpc", "shellies/announce"):
            with contextlib.suppress(WireError):
                assert shelly.read_message(topic, payload, retained=False) == ()
