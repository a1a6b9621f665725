"""Builder of parts."""

import pytest

from homebot.conventions.description import AutoExpiry, Publication
from homebot.conventions.part_builder import JsonPart, with_own_ids
from homebot.conventions.payload import JsonMessage, Readings
from homebot.conventions.table_codec import is_movable, moved
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

ASK = Publication("t/get", b"")


def read_state(message: JsonMessage) -> Readings:
    return {"on_off": message.get("state") == "ON"}


def write(value: PlainValue, transition: float) -> tuple[Publication, ...]:
    if value is False:
        raise RefusedError("a command on t/set", "no")
    return (Publication("t/set", f"{value} in {transition:g}".encode()),)


def part() -> JsonPart:
    made = JsonPart("id", "light", name="n", advertised="lamp", tag="x", category="config", guessed=True)
    made.read_from("t", read_state)
    made.read_events_from("t/event", lambda message: {"press": str(message.get("action"))})
    made.add_capability("on_off", writer=write)
    made.add_capability("press", options=("a",))
    made.add_capability("level", readable=False)
    made.add_command_topics("t/set", "t/set")
    made.add_state_request(ASK, ASK)
    made.add_expiry(AutoExpiry("press", 1.0))
    return made


def test_a_part_has_the_collected_capabilities() -> None:
    described = part().build()
    about = described.part
    assert (about.id, about.service_type, about.name, about.advertised) == ("id", "light", "n", "lamp")
    assert (about.tag, about.category, about.guessed) == ("x", "config", True)
    assert [(one.name, one.readable, one.settable) for one in about.capabilities] == [
        ("on_off", True, True),
        ("press", True, False),
    ]
    assert (about.reads, about.writes, described.state_requests) == (("t", "t/event"), ("t/set",), (ASK,))
    assert described.expiries == (AutoExpiry("press", 1.0),)
    assert described.codec.topics() == about.reads


def test_a_moved_part_reads_and_writes_on_its_own_topics() -> None:
    described, topics = part().build(), {"t": "u", "t/event": "u/event", "t/set": "u/set", "t/get": "u/get"}
    assert is_movable(described, topics)
    other = moved(described, topics, part_id="other")
    assert (other.part.id, other.part.name, other.part.capabilities) == ("other", "n", described.part.capabilities)
    assert (other.part.reads, other.part.writes, other.codec.topics()) == (
        ("u", "u/event"),
        ("u/set",),
        ("u", "u/event"),
    )
    assert (other.state_requests, other.expiries) == ((Publication("u/get", b""),), described.expiries)
    assert other.codec.read("u", b'{"state":"ON"}', retained=True) == {"on_off": True}
    assert other.codec.read("t", b'{"state":"ON"}', retained=True) == {}
    assert other.codec.read("u/event", b'{"action":"x"}', retained=False) == {"press": "x"}
    assert other.codec.write("on_off", value=True) == (Publication("u/set", b"True in 0"),)
    with pytest.raises(RefusedError, match=r"^a command on u/set was refused: no$"):
        other.codec.write("on_off", value=False)


def test_a_part_that_remembers_or_uses_other_topics_is_not_moved() -> None:
    remembering = part()
    remembering.remembers()
    topics = ("t", "t/event", "t/set", "t/get")
    assert not is_movable(remembering.build(), topics)
    assert not is_movable(part().build(), topics[:3])


def test_equal_capabilities_are_one_value() -> None:
    first, second = (part().build().part.capabilities for _ in range(2))
    assert first[0] is second[0]


def test_many_options_are_not_kept_for_others() -> None:
    long = tuple(f"effect {index}" for index in range(200))
    made = [JsonPart("id", "light") for _ in range(2)]
    for one in made:
        one.add_capability("effect", options=long)
    first, second = (one.build().part.capabilities[0] for one in made)
    assert first == second
    assert first is not second


def test_a_part_without_capabilities_is_empty() -> None:
    assert JsonPart("", "x_unknown").is_empty
    assert not part().is_empty


def test_parts_with_one_id_are_numbered_and_cut() -> None:
    parts = [JsonPart(part_id, "light").build() for part_id in ("a", "a", "a_2", "a", "b")]
    assert [one.part.id for one in with_own_ids(parts, 4)] == ["a", "a_2", "a_2_2", "a_3"]
