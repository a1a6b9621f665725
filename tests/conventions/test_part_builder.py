"""Builder of parts."""

from homebot.conventions.description import AutoExpiry, Publication
from homebot.conventions.part_builder import JsonPart, with_own_ids
from homebot.conventions.payload import JsonMessage, Readings
from homebot.devices.value import PlainValue

ASK = Publication("t/get", b"")


def read_state(message: JsonMessage) -> Readings:
    return {"on_off": message.get("state") == "ON"}


def write(value: PlainValue, transition: float) -> tuple[Publication, ...]:
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


def test_a_part_reads_and_writes_by_its_tables() -> None:
    codec = part().build().codec
    assert codec.read("t", b'{"state":"ON"}', retained=True) == {"on_off": True}
    assert codec.write("on_off", value=True, transition=2.0) == (Publication("t/set", b"True in 2"),)


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
