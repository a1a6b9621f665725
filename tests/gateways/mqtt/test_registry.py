"""What stands, held to a simple model of who reads what."""

from collections.abc import Mapping
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import Availability, DescribedPart, DeviceAnnounced, Publication, TextEndpoint
from homebot.conventions.text_codec import TextCodec
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.registry import RegistryLimits
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.mqtt.topics import topic_matches

KEYS = ("one", "two", "three")
FILTERS = ("s/a", "s/b", "s/+", "t/#", "#", "bad+")
TOPICS = ("s/a", "s/b", "s/c", "t/x/y")


@dataclass(frozen=True)
class Codec:
    filters: tuple[str, ...]

    def topics(self) -> tuple[str, ...]:
        return self.filters

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        del topic, payload, retained
        return {}

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        del value, transition
        raise RefusedError(capability, "it takes nothing")


@dataclass(frozen=True)
class Online:
    topic: str

    def read(self, payload: bytes) -> bool | None:
        return bool(payload)


def described(
    key: str, *filters: tuple[str, ...], online: tuple[str, ...] = (), ids: tuple[str, ...] = ()
) -> DeviceAnnounced:
    parts = tuple(
        DescribedPart(Part(id=str(number), service_type="light"), Codec(one)) for number, one in enumerate(filters)
    )
    availability = Availability(tuple(Online(one) for one in online)) if online else None
    return DeviceAnnounced(key, "test", ids, key, parts, f"hello/{key}", availability=availability)


def empty(bounds: RegistryLimits = RegistryLimits()) -> tuple[AnnouncementRegistry, StateTopics]:  # noqa: B008 - a frozen value
    topics = StateTopics(())
    return AnnouncementRegistry("mqtt", (), topics, bounds), topics


FILTER_SETS = st.lists(st.sampled_from(FILTERS), max_size=3).map(tuple)
DESCRIPTIONS = st.tuples(st.sampled_from(KEYS), st.lists(FILTER_SETS, max_size=3), FILTER_SETS)


@given(st.lists(DESCRIPTIONS | st.sampled_from(KEYS), max_size=12))
def test_each_topic_finds_its_present_readers(
    steps: list[tuple[str, list[tuple[str, ...]], tuple[str, ...]] | str],
) -> None:
    registry, topics = empty()
    standing: dict[str, DeviceAnnounced] = {}
    for step in steps:
        if isinstance(step, str):
            assert (registry.remove(f"test:{step}") is not None) == (step in standing)
            standing.pop(step, None)
        else:
            key, filters, online = step
            standing[key] = described(key, *filters, online=online)
            change = registry.put(standing[key])
            assert change.stored.described is standing[key]
        for topic in TOPICS:
            route = registry.route(topic)
            found = (
                {(one.stored.described.key, one.described.part.id) for one in route.announced_parts} if route else set()
            )
            assert found == {
                (key, part.part.id)
                for key, one in standing.items()
                for part in one.parts
                if any(good(each) and topic_matches(each, topic) for each in part.codec.topics())
            }
    for key in KEYS:
        registry.remove(f"test:{key}")
    assert (len(registry.by_key), len(topics.users), registry._parts) == (0, 0, 0)
    assert all(registry.route(topic) is None for topic in TOPICS)


def good(topic_filter: str) -> bool:
    return topic_filter not in {"#", "bad+"}


def test_a_new_reader_of_a_topic_in_use_gets_its_last_message_once() -> None:
    registry, _ = empty()
    registry.put(described("one", ("s/a",), online=("s/b",)))
    second = described("two", ("s/a", "s/c"), online=("s/b",))
    assert [topic for topic, _ in registry.put(second).readers] == ["s/a", "s/b"]
    assert registry.put(second).readers == ()


def test_the_state_of_a_device_outlives_a_new_description() -> None:
    registry, _ = empty()
    first = registry.put(described("one", ("s/a",), online=("s/b",))).stored
    first.reachability[""].update(0, True, retained=False)
    first.is_confirmed = True
    second = registry.put(described("one", ("s/c",), online=("s/b",))).stored
    assert second.reachability[""] is first.reachability[""]
    assert second.is_confirmed
    third = registry.put(described("one", ("s/c",), online=("s/d",))).stored
    assert third.reachability[""].value is None


def test_the_announcements_of_a_device_share_one_reader_of_each_availability_topic() -> None:
    registry, topics = empty()
    for key in ("light", "sensor", "update"):
        registry.put(described(key, ("s/a",), online=("s/bridge", "s/online"), ids=("id:lamp",)))
    registry.put(described("other", ("s/b",), online=("s/bridge",), ids=("id:plug",)))
    bridge, online = registry.route("s/bridge"), registry.route("s/online")
    assert bridge is not None
    assert online is not None
    assert (len(bridge.availability_readers), len(online.availability_readers)) == (2, 1)
    (reader,) = online.availability_readers
    assert [stored.described.key for stored, _ in reader.reachability.members] == ["light", "sensor", "update"]
    for key in ("light", "sensor"):
        registry.remove(f"test:{key}")
    assert registry.route("s/online") is online
    registry.remove("test:update")
    assert registry.route("s/online") is None
    assert topics.users.keys() == {"s/b", "s/bridge"}


def test_too_many_parts_are_refused_and_what_stood_stays() -> None:
    registry, topics = empty()
    registry.put(described("one", ("s/a",)))
    with pytest.raises(WireError, match="has 1001 parts; 1,000 is the limit"):
        registry.put(described("one", *[("s/b",)] * 1001))
    assert registry.by_key.get("test:one") is not None
    assert len(topics.users) == 1


@pytest.mark.parametrize(
    ("bounds", "words"),
    [(RegistryLimits(announcements=1), "limit of 1 announcements"), (RegistryLimits(parts=1), "limit of 1 parts")],
)
def test_one_too_many_is_refused_and_a_known_one_is_not(bounds: RegistryLimits, words: str) -> None:
    registry, _ = empty(bounds)
    registry.put(described("one", ("s/a",)))
    registry.put(described("one", ("s/b",)))
    with pytest.raises(WireError, match=words):
        registry.put(described("two", ("s/a",)))
    registry.remove("test:one")
    registry.put(described("two", ("s/a",)))


def test_a_topic_is_read_by_so_many_parts_only() -> None:
    registry, _ = empty(RegistryLimits(readers=2))
    change = registry.put(described("one", ("s/a",), ("s/a",), ("s/a",)))
    assert [str(one) for one in change.refused] == ["topic 's/a' already has 2 readers, the limit"]
    route = registry.route("s/a")
    assert route is not None
    assert len(route.announced_parts) == 2


def test_a_description_that_fails_leaves_nothing_behind() -> None:
    registry, topics = empty()
    with pytest.raises(TypeError):
        registry.put(described("one", ("s/a",), 5))  # type: ignore[arg-type] # as a faulty plug-in might
    assert (len(registry.by_key), len(topics.users), registry._parts) == (0, 0, 0)
    assert registry.route("s/a") is None


def test_the_streams_of_a_device_are_bounded() -> None:
    registry, _ = empty()
    stored = registry.put(described("one", ("s/+",))).stored
    names = {stored.report_stream(f"s/{number}") for number in range(2000)}
    assert len(names) == len(stored.report_streams) == 1001


def text_device(key: str, topic: str, convention: str = "text") -> DeviceAnnounced:
    part = Part(id="", service_type="light", reads=(f"{topic}/out",), writes=(f"{topic}/in",))
    endpoint = TextEndpoint("lights", f"{topic}/out", f"{topic}/in")
    return DeviceAnnounced(
        key, convention, (), key, (DescribedPart(part, TextCodec(part)),), f"{topic}/out", text=endpoint
    )


def test_a_device_that_says_text_is_found_by_both_of_its_topics_as_long_as_it_stands() -> None:
    registry, topics = empty()
    stored = registry.put(text_device("lights/lamp", "h/lights/lamp")).stored
    route = registry.route("h/lights/lamp/out")
    assert route is not None
    assert (route.text, route.announced_parts, route.texts) == (stored.parts[""], (), ())
    assert registry.codecs["h/lights/lamp/in"] is stored.parts[""].described.codec
    assert len(topics.users) == 0
    registry.remove("lights/lamp")
    assert (registry.route("h/lights/lamp/out"), registry.codecs) == (None, {})


def test_the_key_of_a_device_that_says_text_cannot_be_taken_by_another_convention() -> None:
    registry, _ = empty()
    registry.put(described("lamp", ("s/a",)))
    with pytest.raises(WireError, match="'test:lamp' is already the key of a device of test"):
        registry.put(text_device("test:lamp", "test:lamp"))
    assert registry.route("test:lamp/out") is None
