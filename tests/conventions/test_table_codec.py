"""Codec of tables: messages and commands."""

import math

import pytest

from homebot.conventions.description import Publication
from homebot.conventions.payload import JsonMessage
from homebot.conventions.table_codec import TableCodec, json_object
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError


def write(value: PlainValue, transition: float) -> tuple[Publication, ...]:
    return (Publication("t/set", f"{value} in {transition:g}".encode()),)


def of_bytes() -> TableCodec[bytes]:
    return TableCodec(
        bytes,
        {"t": (lambda payload: {"on_off": payload == b"on"},), "e": ()},
        {"t": (lambda _payload: {"press": "single"},), "e": (lambda _payload: {"press": "double"},)},
        {"on_off": write},
    )


def of_objects() -> TableCodec[JsonMessage]:
    def read(message: JsonMessage) -> dict[str, PlainValue]:
        return {"on_off": message.get("state") == "ON"}

    return TableCodec(json_object, {"t": (read,)}, {}, {})


def test_a_message_is_read_by_all_and_a_kept_event_is_none() -> None:
    codec = of_bytes()
    assert codec.topics() == ("t", "e")
    assert codec.read("t", b"on", retained=False) == {"on_off": True, "press": "single"}
    assert codec.read("t", b"on", retained=True) == {"on_off": True}
    assert codec.read("e", b"", retained=False) == {"press": "double"}
    assert codec.read("e", b"", retained=True) == {}
    assert codec.read("other", b"on", retained=False) == {}


def test_a_filter_is_read_after_the_exact_topic() -> None:
    codec = TableCodec(
        bytes,
        {"a/b": (lambda _payload: {"value": "exact", "state": True},), "+/b": (lambda _payload: {"value": "wild"},)},
        {"+/b": (lambda _payload: {"press": "single"},)},
        {},
    )
    assert codec.read("a/b", b"", retained=True) == {"value": "wild", "state": True}
    assert codec.read("c/b", b"", retained=False) == {"value": "wild", "press": "single"}
    assert codec.read("c/d", b"", retained=False) == {}


@pytest.mark.parametrize("payload", [b"", b"ON", b"[1]", b"\xff", b"{" * 9_999, b"{}" + b" " * 300_000])
def test_another_response_is_no_refusal(payload: bytes) -> None:
    assert of_objects().read("t", payload, retained=False) == {}


def test_an_unknown_capability_is_refused_with_the_known_ones() -> None:
    with pytest.raises(RefusedError, match="this part takes on_off"):
        of_bytes().write("level", 1.0)
    with pytest.raises(RefusedError, match="this part takes nothing"):
        of_objects().write("on_off", value=True)


@pytest.mark.parametrize("transition", [-1.0, math.nan, math.inf])
def test_a_transition_is_some_seconds(transition: float) -> None:
    with pytest.raises(RefusedError, match="seconds"):
        of_bytes().write("on_off", value=True, transition=transition)
