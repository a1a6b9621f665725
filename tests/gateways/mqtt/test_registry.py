"""What stands, held to a simple model of who reads what."""

from __future__ import annotations

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
from homebot.gateways.mqtt.registry import AnnouncementRegistry, RegistryLimits
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


def described(key: str, *filters: tuple[str, ...], online: tuple[str, ...] = ()) -> DeviceAnnounced:
    parts = tuple(
        DescribedPart(Part(id=str(number), service_type="light"), Codec(one)) for number, one in enumerate(filters)
    )
    availability = Availability(tuple(Online(one) for one in online)) if online else None
    return DeviceAnnounced(key, "test", (), key, parts, f"hello/{key}", availability=availability)


def empty(bounds: RegistryLimits = RegistryLimits()) -> tuple[AnnouncementRegistry, StateTopics]:  # noqa: B008 - a frozen value
    topics = StateTopics(())
    return AnnouncementRegistry("mqtt", (), topics, bounds), topics


FILTER_SETS = st.lists(st.sampled_from(FILTERS), max_size=3).map(tuple)
DESCRIPTIONS = st.tuples(st.sampled_from(KEYS), st.lists(FILTER_SETS, max_size=3), FILTER_SETS)


@given(st.lists(DESCRIPTIONS | st.sampled_from(KEYS), max_size=12))
def test_each_topic_finds_who_reads_it_now(
    steps: list[tuple[str, list[tuple[str, ...]], tuple[str, ...]] | str],
) -> None:
    claims, topics = empty()
    standing: dict[str, DeviceAnnounced] = {}
    for step in steps:
        if isinstance(step, str):
            assert (claims.remove(f"test:{step}") is not None) == (step in standing)
            standing.pop(step, None)
        else:
            key, filters, online = step
            standing[key] = described(key, *filters, online=online)
            change = claims.put(standing[key])
            assert change.claim.described is standing[key]
        for topic in TOPICS:
            route = claims.route(topic)
            found = {(one.claim.described.key, one.described.part.id) for one in route.voices} if route else set()
            assert found == {
                (key, part.part.id)
                for key, one in standing.items()
                for part in one.parts
                if any(good(each) and topic_matches(each, topic) for each in part.codec.topics())
            }
    for key in KEYS:
        claims.remove(f"test:{key}")
    assert (len(claims), len(topics), claims._parts) == (0, 0, 0)
    assert claims._reader_counts == {}
    assert all(claims.route(topic) is None for topic in TOPICS)


def good(topic_filter: str) -> bool:
    return topic_filter not in {"#", "bad+"}


def test_who_reads_a_topic_that_is_read_already_is_told_once() -> None:
    claims, _ = empty()
    claims.put(described("one", ("s/a",), online=("s/b",)))
    second = described("two", ("s/a", "s/c"), online=("s/b",))
    assert [topic for topic, _ in claims.put(second).readers] == ["s/a", "s/b"]
    assert claims.put(second).readers == ()


def test_what_is_known_of_a_device_outlives_a_new_description() -> None:
    claims, _ = empty()
    first = claims.put(described("one", ("s/a",), online=("s/b",))).claim
    first.reachability[""].hear(0, True, retained=False)
    first.is_confirmed = True
    second = claims.put(described("one", ("s/c",), online=("s/b",))).claim
    assert second.reachability[""] is first.reachability[""]
    assert second.is_confirmed
    third = claims.put(described("one", ("s/c",), online=("s/d",))).claim
    assert third.reachability[""].value is None


def test_too_many_parts_are_refused_and_what_stood_stays() -> None:
    claims, topics = empty()
    claims.put(described("one", ("s/a",)))
    with pytest.raises(WireError, match="more than 1,000"):
        claims.put(described("one", *[("s/b",)] * 1001))
    assert claims.get("test:one") is not None
    assert len(topics) == 1


@pytest.mark.parametrize(
    ("bounds", "words"),
    [(RegistryLimits(claims=1), "announcements already"), (RegistryLimits(parts=1), "too many parts")],
)
def test_one_too_many_is_refused_and_a_known_one_is_not(bounds: RegistryLimits, words: str) -> None:
    claims, _ = empty(bounds)
    claims.put(described("one", ("s/a",)))
    claims.put(described("one", ("s/b",)))
    with pytest.raises(WireError, match=words):
        claims.put(described("two", ("s/a",)))
    claims.remove("test:one")
    claims.put(described("two", ("s/a",)))


def test_a_topic_is_read_by_so_many_parts_only() -> None:
    claims, _ = empty(RegistryLimits(readers=2))
    change = claims.put(described("one", ("s/a",), ("s/a",), ("s/a",)))
    assert [str(one) for one in change.refused] == ["topic 's/a' is read by 2 parts already"]
    route = claims.route("s/a")
    assert route is not None
    assert len(route.voices) == 2


def test_a_description_that_fails_leaves_nothing_behind() -> None:
    claims, topics = empty()
    with pytest.raises(TypeError):
        claims.put(described("one", ("s/a",), 5))  # type: ignore[arg-type] # as a faulty plug-in might
    assert (len(claims), len(topics), claims._parts) == (0, 0, 0)
    assert claims.route("s/a") is None


def test_the_streams_of_a_device_are_bounded() -> None:
    claims, _ = empty()
    claim = claims.put(described("one", ("s/+",))).claim
    names = {claim.report_stream(f"s/{number}") for number in range(1000)}
    assert len(names) == len(claim.report_streams) == 101


def text_device(key: str, topic: str, convention: str = "text") -> DeviceAnnounced:
    part = Part(id="", service_type="light", reads=(f"{topic}/out",), writes=(f"{topic}/in",))
    endpoint = TextEndpoint("lights", f"{topic}/out", f"{topic}/in")
    return DeviceAnnounced(
        key, convention, (), key, (DescribedPart(part, TextCodec(part)),), f"{topic}/out", text=endpoint
    )


def test_a_device_that_says_text_is_found_by_both_of_its_topics_as_long_as_it_stands() -> None:
    claims, topics = empty()
    claim = claims.put(text_device("lights/lamp", "h/lights/lamp")).claim
    route = claims.route("h/lights/lamp/out")
    assert route is not None
    assert (route.text, route.voices, route.texts) == (claim.parts[""], (), ())
    assert claims.codecs["h/lights/lamp/in"] is claim.parts[""].described.codec
    assert len(topics) == 0
    claims.remove("lights/lamp")
    assert (claims.route("h/lights/lamp/out"), claims.codecs) == (None, {})


def test_the_key_of_a_device_that_says_text_cannot_be_taken_by_another_convention() -> None:
    claims, _ = empty()
    claims.put(described("lamp", ("s/a",)))
    with pytest.raises(WireError, match="'test:lamp' is what test calls a device already"):
        claims.put(text_device("test:lamp", "test:lamp"))
    assert claims.route("test:lamp/out") is None
