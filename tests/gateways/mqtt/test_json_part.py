"""A part that speaks JSON: its tables, and what its codec makes of messages."""

import pytest

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import Fade, Publication
from homebot.gateways.mqtt.json_part import JsonMessage, JsonPart, Readings, finite_number, with_own_ids

ASK = Publication("t/get", b"")


def read_state(message: JsonMessage) -> Readings:
    return {"on_off": message.get("state") == "ON"}


def read_press(message: JsonMessage) -> Readings:
    return {"press": str(message.get("action"))}


def write(value: PlainValue, transition: float) -> tuple[Publication, ...]:
    return (Publication("t/set", f"{value} in {transition:g}".encode()),)


def part() -> JsonPart:
    made = JsonPart("id", "light", name="n", advertised="lamp", tag="x", category="config", guessed=True)
    made.hears(read_state, "t")
    made.hears_events(read_press, "t")
    made.offers("on_off", writer=write)
    made.offers("press", options=("a",))
    made.offers("level", readable=False)
    made.listens("t/set", "t/set")
    made.asks(ASK, ASK)
    made.fades(Fade("press", 1.0))
    return made


def test_a_part_has_what_was_collected() -> None:
    described = part().described()
    about = described.part
    assert (about.id, about.service_type, about.name, about.advertised) == ("id", "light", "n", "lamp")
    assert (about.tag, about.category, about.guessed) == ("x", "config", True)
    assert [(one.name, one.readable, one.settable) for one in about.capabilities] == [
        ("on_off", True, True),
        ("press", True, False),
    ]
    assert (about.reads, about.writes, described.asks) == (("t",), ("t/set",), (ASK,))
    assert described.fades == (Fade("press", 1.0),)


def test_a_part_that_can_do_nothing_says_so() -> None:
    assert JsonPart("", "x_unknown").is_empty
    assert not part().is_empty


def test_parts_with_one_id_are_numbered_and_cut() -> None:
    parts = [JsonPart(part_id, "light").described() for part_id in ("a", "a", "a_2", "a", "b")]
    assert [one.part.id for one in with_own_ids(parts, 4)] == ["a", "a_2", "a_2_2", "a_3"]


def test_a_message_is_read_by_all_and_a_kept_event_is_none() -> None:
    codec = part().described().codec
    payload = b'{"state":"ON","action":"a"}'
    assert codec.read("t", payload, retained=False) == {"on_off": True, "press": "a"}
    assert codec.read("t", payload, retained=True) == {"on_off": True}


@pytest.mark.parametrize("payload", [b"", b"ON", b"[1]", b"\xff", b"{" * 9_999, b"{}" + b" " * 300_000])
def test_what_is_no_short_object_says_nothing(payload: bytes) -> None:
    assert part().described().codec.read("t", payload, retained=False) == {}


def test_another_topic_says_nothing() -> None:
    assert part().described().codec.read("other", b"{}", retained=False) == {}


def test_a_command_goes_to_the_writer_of_its_capability() -> None:
    codec = part().described().codec
    assert codec.write("on_off", value=True, transition=2.0) == (Publication("t/set", b"True in 2"),)
    with pytest.raises(RefusedError, match="this part takes on_off"):
        codec.write("press", "a")


@pytest.mark.parametrize(
    ("value", "expected"),
    [(1, 1.0), (-2.5, -2.5), (True, None), ("1", None), (None, None), (10**400, None), (1e300, None)],
)
def test_a_number_is_one_that_devices_have(value: object, expected: float | None) -> None:
    assert finite_number(value) == expected
