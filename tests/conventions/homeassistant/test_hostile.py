"""Any message is read or refused, in bounded time."""

import json
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.conventions.homeassistant.components import BUILDERS
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

pytestmark = pytest.mark.slow

TOPICS = [f"homeassistant/{component}/x/config" for component in (*sorted(BUILDERS), "device")]
DEVICE = {"identifiers": ["i"], "name": "n"}
VALID: list[dict[str, Any]] = [
    {"schema": "json", "cmd_t": "a/set", "stat_t": "a", "sup_clrm": ["rgbww", "color_temp"], "fx_list": ["x"]},
    {
        "cmd_t": "a/set",
        "stat_t": "a",
        "rgb_cmd_t": "a/rgb/set",
        "rgb_stat_t": "a",
        "bri_cmd_t": "a/b/set",
        "clr_temp_cmd_t": "a/ct/set",
        "clr_temp_stat_t": "a",
        "on_cmd_type": "first",
    },
    {
        "schema": "template",
        "cmd_t": "a/set",
        "stat_t": "a",
        "cmd_on_tpl": "on {{ brightness }}",
        "cmd_off_tpl": "off",
        "stat_tpl": "{{ value_json.s }}",
        "r_tpl": "{{ value }}",
        "g_tpl": "{{ value }}",
        "b_tpl": "{{ value }}",
        "bri_tpl": "{{ value }}",
        "clr_temp_tpl": "{{ value }}",
    },
    {
        "cmd_t": "a/set",
        "stat_t": "a",
        "pos_t": "a",
        "set_pos_t": "a/pos/set",
        "set_pos_tpl": '{"p": {{ position }}}',
        "tilt_cmd_t": "a/tilt/set",
        "tilt_status_t": "a",
        "avty": {"t": "a/av"},
        "~": "b",
    },
    {"cmd_t": "a/set", "stat_t": "a", "reports_position": True, "pos_open": 255, "av_tones": ["t"], "dev": DEVICE},
    {
        "cmd_t": "a/set",
        "stat_t": "+/a",
        "pct_cmd_t": "a/p",
        "pct_stat_t": "a",
        "pr_modes": ["m"],
        "pr_mode_stat_t": "a",
    },
    {"dev": DEVICE, "o": {"name": "o"}, "cmps": {"c": {"p": "cover", "uniq_id": "u", "cmd_t": "a/set", "pos_t": "a"}}},
]

scalars = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(
        ["{{ value_json.x }}", "{{ 9**9**9 }}", "a/+", "\x00", "\ud800", "9" * 400, 10**40, -1, 0, "None"]
    )
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
        st.sampled_from(
            [
                "state",
                "brightness",
                "color",
                "color_mode",
                "color_temp",
                "position",
                "tilt_position",
                "effect",
                "s",
                "tone",
            ]
        ),
        anything
        | st.dictionaries(st.sampled_from(list("hsxyrgbcw")), scalars)
        | st.sampled_from(["ON", "rgbww", "hs", "xy"]),
    ),
)
values = st.none() | st.booleans() | st.floats() | st.text(max_size=5) | st.tuples(st.floats(), st.floats())


def mutated() -> st.SearchStrategy[dict[str, Any]]:
    return st.builds(
        lambda valid, changes: {**valid, **changes},
        st.sampled_from(VALID),
        st.dictionaries(st.sampled_from(sorted({key for valid in VALID for key in valid})), anything, max_size=2),
    )


def use(topic: str, payload: bytes, heard: bytes, value: PlainValue, transition: float) -> None:
    """Take a config, let its parts hear something, and tell each of its capabilities something."""
    try:
        found = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(topic, payload, retained=True)
    except WireError:
        return
    for one in found:
        for described in one.parts if isinstance(one, DeviceAnnounced) else ():
            for spoken in described.codec.topics():
                described.codec.read(spoken.replace("+", "x").replace("#", "x"), heard, retained=False)
            for capability in described.part.capabilities:
                with suppress(RefusedError):
                    described.codec.write(capability.name, value, transition=transition)


@given(st.sampled_from(TOPICS), mutated(), said | states, values, st.floats())
def test_any_change_to_a_valid_config_is_taken_or_refused(
    topic: str, fields: dict[str, Any], heard: bytes, value: PlainValue, transition: float
) -> None:
    use(topic, json.dumps(fields).encode(), heard, value, transition)


@pytest.mark.parametrize(
    "payload",
    [
        b"x" * 5_000_000,
        b'{"a":' * 10_000,
        b"[" * 10_000 + b"]" * 10_000,
        b'{"command_topic": NaN}',
        b'{"command_topic": "\\ud800"}',
        json.dumps({"cmps": {f"c{n}": {"p": "switch", "cmd_t": "a"} for n in range(10_000)}, "dev": DEVICE}).encode(),
        json.dumps({"command_topic": "a", "device": {"identifiers": [str(n) for n in range(10_000)]}}).encode(),
        json.dumps({"command_topic": "a/+/set"}).encode(),
        json.dumps({"command_topic": "a" * 70_000}).encode(),
    ],
    ids=range(9),
)
@pytest.mark.parametrize("topic", ["homeassistant/switch/x/config", "homeassistant/device/x/config"])
def test_an_attack_is_refused(topic: str, payload: bytes) -> None:
    with pytest.raises(WireError) as refused:
        HomeAssistantDiscovery(HomeAssistantSettings()).read_message(topic, payload, retained=False)
    assert len(str(refused.value)) < 400


def test_a_name_of_any_length_and_content_is_cut_to_a_line() -> None:
    fields = {"cmd_t": "a", "name": "<b>\x1b[31m" + "n" * 8_000, "dev": {"ids": "x", "name": "d\n" + "n" * 100_000}}
    payload = json.dumps(fields).encode()
    (found,) = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(
        "homeassistant/switch/x/config", payload, retained=True
    )
    assert isinstance(found, DeviceAnnounced)
    assert (found.name[:4], len(found.name)) == ("d nn", 120)
    assert (found.parts[0].part.name[:8], len(found.parts[0].part.name)) == ("<b> [31m", 120)


def test_a_long_state_is_not_looked_at() -> None:
    payload = json.dumps({"cmd_t": "a/set", "stat_t": "a"}).encode()
    (found,) = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(
        "homeassistant/switch/x/config", payload, retained=True
    )
    assert isinstance(found, DeviceAnnounced)
    assert found.parts[0].codec.read("a", b"ON" + b" " * 300_000, retained=False) == {}


def test_a_valve_without_a_stop_has_a_payload_of_null() -> None:
    """Found by fuzzing: a payload that is null means that there is no such command."""
    payload = json.dumps({"cmd_t": "v/set", "stat_t": "v", "payload_stop": None}).encode()
    (found,) = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(
        "homeassistant/valve/x/config", payload, retained=True
    )
    assert isinstance(found, DeviceAnnounced)
    (told,) = found.parts[0].codec.write("valve", "open")
    assert told.payload == b"OPEN"
    with pytest.raises(RefusedError):
        found.parts[0].codec.write("valve", "stopped")
