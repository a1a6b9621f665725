"""Any config and any message of a part is read or refused, in words of the vocabulary."""

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.conventions.announced_parts import homeassistant_parts

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.components import BUILDERS
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

LINES = [
    line
    for name in ("parts.jsonl", "controls.jsonl")
    for line in Path(__file__).with_name(name).read_text().splitlines()
]
REAL: list[dict[str, Any]] = [json.loads(line) for line in LINES]
WHOLE = {"dev": {"identifiers": ["i"]}, "cmps": {"c": {"p": "cover", "uniq_id": "u", "cmd_t": "a/set", "pos_t": "a"}}}
MORE: list[dict[str, Any]] = [
    {"component": "device", "config": WHOLE},
    {"component": "tag", "config": {"topic": "t", "value_template": "{{ value_json.x }}"}},
    {"component": "notify", "config": {"cmd_t": "n"}},
    {"component": "date", "config": {"cmd_t": "d/set", "stat_t": "d"}},
    {"component": "time", "config": {"cmd_t": "d/set", "stat_t": "d"}},
    {"component": "datetime", "config": {"cmd_t": "d/set", "stat_t": "d"}},
    {"component": "device_automation", "config": {"atype": "trigger", "t": "t", "type": "a", "stype": "b", "pl": "x"}},
]
KINDS = {"bool": bool, "number": float, "text": str, "numbers": tuple}
WORDS = sorted({word for one in REAL for word in one["config"]} | {"state", "x", "event_type"})

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["{{ value_json.x }}", "{{ 9**9**9 }}", "a/+", "\x00", "9" * 400, 10**40, -1, 0, "None", "nan"])
)
anything = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(WORDS), inner, max_size=3),
    max_leaves=6,
)
said = (
    st.binary(max_size=40)
    | st.builds(lambda value: json.dumps(value).encode(), anything)
    | st.sampled_from([payload.encode() for one in REAL for _, payload, _ in one.get("says", ())])
    | st.sampled_from([b"ON", b"OFF", b"off", b"heat", b"21.5", b"2026-11-20", b"0001-01-01T00:00:00+23:00", b""])
)
values = (
    st.none()
    | st.booleans()
    | st.floats()
    | st.text(max_size=5)
    | st.tuples(st.floats(), st.floats())
    | st.sampled_from(["heat", "off", "disarmed"])
)
components = st.just("") | st.sampled_from([*sorted(BUILDERS), "device"])
"""Nothing, or a component that is not that of the config."""
changes = st.dictionaries(st.sampled_from(WORDS), anything, max_size=2)


def described(component: str, one: Mapping[str, Any], changed: Mapping[str, object]) -> tuple[DescribedPart, ...]:
    try:
        return homeassistant_parts(component or one["component"], {**one["config"], **changed})
    except WireError:
        return ()


def is_ours(part: DescribedPart, capability: str, value: PlainValue) -> bool:
    kind = KINDS[CAPABILITIES[capability].kind]
    known = {one.name for one in part.part.capabilities}
    return capability in known and (
        value is None or (type(value) is kind and (not isinstance(value, float) or math.isfinite(value)))
    )


@given(st.sampled_from(REAL + MORE), components, changes, said)
def test_readings_are_of_the_capabilities_and_their_kinds(
    one: dict[str, Any], component: str, changed: dict[str, Any], payload: bytes
) -> None:
    for part in described(component, one, changed):
        for spoken in part.codec.topics():
            topic = spoken.replace("+", "x").replace("#", "x")
            read = part.codec.read(topic, payload, retained=False)
            assert all(is_ours(part, capability, value) for capability, value in read.items()), read


@given(st.sampled_from(REAL + MORE), components, changes, values, st.just(0.0) | st.floats())
def test_commands_are_published_on_the_command_topics(
    one: dict[str, Any], component: str, changed: dict[str, Any], value: PlainValue, transition: float
) -> None:
    for part in described(component, one, changed):
        for capability in part.part.capabilities:
            with suppress(RefusedError):
                published = part.codec.write(capability.name, value, transition=transition)
                assert capability.settable
                assert {one.topic for one in published} <= set(part.part.writes)
