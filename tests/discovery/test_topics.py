"""Who may be told something on a topic that several announcements name, whatever the order in which they come."""

from collections.abc import Iterable
from itertools import permutations
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of
from tests.call_counts import calls

from homebot.devices import KeyValue, Sighting
from homebot.devices.part import Part
from homebot.discovery.source_record import SourceRecord
from homebot.discovery.topics.ownership import MAX_LEVELS, MAX_TOPICS, MAX_USERS, NOBODY, TopicOwnership
from homebot.discovery.topics.use import TopicUse, topic_use

GATEWAY = "mqtt"


def use(
    device: str,
    *writes: str,
    on: str = "",
    owns: tuple[str, ...] = (),
    key: str = "",
    bridge: str = "",
    reads: tuple[str, ...] = (),
    is_anonymous: bool = False,
    is_native: bool = False,
    asks: bool = False,
    base: str = "",
) -> TopicUse:
    return TopicUse(
        key=(GATEWAY, key or f"{device} {on}"),
        device=device,
        announced_on=f"homeassistant/light/{on}/config" if on else "",
        writes=writes,
        reads=reads,
        owns=owns,
        bridge=bridge,
        is_anonymous=is_anonymous,
        is_native=is_native,
        asks=asks,
        base=base,
    )


def verdicts(*uses: TopicUse) -> dict[str, bool]:
    """Whether each may use all that it wants; the same for every order of arrival."""
    found: list[dict[str, bool]] = []
    for order in permutations(uses):
        disputes = TopicOwnership()
        for one in order:
            disputes.put(one)
        found.append({one.key[1]: not any(disputes.owner(one.key, topic) for topic in one.writes) for one in uses})
    assert all(one == found[0] for one in found)
    return found[0]


@pytest.mark.parametrize(
    "topic",
    ["z/0x17", "z/0x17/set", "z/0x17/set/state", "z/door/set", "z/door/1/set/lock", "z/door"],
)
def test_below_a_devices_own_topics_nobody_else_is_told_anything(topic: str) -> None:
    door = use("door", "z/door/set", owns=("z/door", "z/0x17"))
    assert verdicts(door, use("evil", topic, on="evil")) == {"door ": True, "evil evil": False}
    assert verdicts(door, use("evil", topic, on="evil", bridge="b")) == {"door ": True, "evil evil": False}
    assert verdicts(door, use("door", topic, on="evil")) == {"door ": True, "door evil": False}
    assert verdicts(door, use("door", topic, on="0x17/lock")) == {"door ": True, "door 0x17/lock": True}


@pytest.mark.parametrize("topic", ["z/hall group/set", "z/7/set", "z/door/left/set", "z/lamp/set"])
def test_below_the_base_of_a_bridge_with_a_lock_no_other_program_is_told_anything(topic: str) -> None:
    """Zigbee2MQTT takes a command to the lock on topics that only it knows, such as those of its groups."""
    door = use("door", "z/door/set", owns=("z/door",), bridge="b", asks=True, base="z")
    lamp = use("lamp", "z/lamp/set", on="lamp", bridge="b")
    assert verdicts(door, lamp, use("evil", topic, on=topic)) == {
        "door ": True,
        "lamp lamp": True,
        f"evil {topic}": False,
    }
    assert all(verdicts(door, lamp, use("other", "x/lamp/set", on="other")).values())
    gone = TopicOwnership()
    for one in (door, stranger := use("evil", topic, on="evil")):
        gone.put(one)
    gone.discard(door.key)
    assert not gone.owner(stranger.key, topic)


def test_a_further_lock_of_a_bridge_costs_no_look_at_all_its_topics() -> None:
    """Each of hundreds of locks judged all topics of a bridge again, which took half of the time of a start."""
    locks = [
        use(f"lock{number}", f"z/{number}/set", owns=(f"z/{number}",), bridge=bridge, asks=True, base="z")
        for number, bridge in enumerate(("b", "b", "other"))
    ]
    topics = TopicOwnership()
    lamps = [use(f"lamp {number}", f"z/lamp {number}/set", bridge="b") for number in range(500)]
    for one in (locks[0], *lamps):
        topics.put(one)

    assert calls(lambda: topics.put(locks[1])) < 200
    assert topics.put(locks[2]) == frozenset(), "two bridges may use the topics below"
    assert calls(lambda: topics.discard(locks[1].key)) < 200
    assert topics.discard(locks[0].key) == {one.device for one in lamps}


@pytest.mark.parametrize(
    ("topic", "name", "base"),
    [
        ("zigbee2mqtt/Front door/set", "Front door", "zigbee2mqtt"),
        ("home/zigbee/hall/Front door/set", "hall/Front door", "home/zigbee"),
        ("home/zigbee/Front door/set", "renamed lock", "home/zigbee"),
    ],
)
def test_a_lock_known_by_its_announcement_alone_owns_its_topics_and_tells_the_base(
    topic: str, name: str, base: str
) -> None:
    part = Part(id="lock", service_type="door_lock", writes=(topic,))
    alone = sighting_of("front_door", part, name=name, identifiers=("eui64:00158d0001abcdef",))
    via = (KeyValue(key="via_device", value="zigbee2mqtt_bridge_0x1"),)
    found = topic_use(source_of(alone.model_copy(update={"metadata": via})), "front_door")
    assert (found.base, found.owns) == (base, (f"{base}/{name}", f"{base}/0x00158d0001abcdef"))
    assert not topic_use(source_of(alone), "front_door").base
    known_by = (*alone.identifiers, "id:zigbee2mqtt_0x00158d0001abcdef")  # without via_device
    assert topic_use(source_of(alone.model_copy(update={"identifiers": known_by})), "front_door").base == base


def source_of(sighting: Sighting) -> SourceRecord:
    return SourceRecord(sighting, 0, sighting.seen_at, sighting.seen_at, confirmed=True)


def test_a_topic_beside_a_devices_own_is_free() -> None:
    door = use("door", "z/door/set", owns=("z/door",))
    assert all(verdicts(door, use("lamp", "z/doors/set", on="lamp")).values())


def test_a_topic_belongs_to_who_was_announced_where_that_names_it_best() -> None:
    kitchen = use("kitchen", "kitchen_lamp/set", on="kitchen_lamp")
    assert verdicts(kitchen, use("evil", "kitchen_lamp/set", on="evil")) == {
        "kitchen kitchen_lamp": True,
        "evil evil": False,
    }
    assert verdicts(kitchen, use("other", "kitchen_lamp/set", on="kitchen_plug")) == {
        "kitchen kitchen_lamp": True,
        "other kitchen_plug": False,
    }


@pytest.mark.parametrize("word", ["light", "set", "plug", "homeassistant", "config", "1"])
def test_a_word_that_many_have_names_nobody(word: str) -> None:
    topic = f"house/{word}/set"
    assert verdicts(use("lock", topic, on="x17"), use("evil", topic, on=word)) == {
        "lock x17": False,
        f"evil {word}": False,
    }


def test_what_two_devices_have_equal_right_to_neither_may_use() -> None:
    assert not any(verdicts(use("a", "t", on="x1"), use("b", "t", on="x2")).values())
    assert not any(verdicts(use("a", "t", on="x1"), use("b", "t", on="x2", is_anonymous=True)).values())
    assert not any(verdicts(use("a", "t", on="x1", bridge="h"), use("b", "t", on="x2", bridge="h")).values())


def test_two_announcements_of_one_device_share_its_topic_where_their_places_have_a_name_in_common() -> None:
    assert all(verdicts(use("a", "t", on="0x17/light"), use("a", "t", on="0x17/effect")).values())
    assert all(verdicts(use("a", "t", on="desk_light"), use("a", "t", on="desk_effect")).values())
    assert not any(verdicts(use("a", "t", on="desk"), use("a", "t", on="evil")).values())


def test_the_device_itself_counts_more_than_what_another_says_of_it() -> None:
    own = use("a", "t", on="x", is_native=True)
    assert verdicts(own, use("a", "t", on="evil")) == {"a x": True, "a evil": False}


def test_devices_behind_one_bridge_and_those_that_do_not_say_who_they_are_share_its_topic() -> None:
    """Three are evidently meant so; two where the places of both name the bridge."""
    crowd = [use(f"d{number}", "ir/send", on=f"x{number}", bridge="ir") for number in range(3)]
    assert all(verdicts(*crowd).values())
    nameless = [use(f"d{number}", "ir/send", on=f"x{number}", is_anonymous=True) for number in range(3)]
    assert all(verdicts(*nameless).values())
    pair = [use(f"d{number}", "ir/send", on=f"blaster_{number}", bridge="ir") for number in range(2)]
    assert all(verdicts(*pair).values())


@pytest.mark.parametrize("shared", [{"is_anonymous": True}, {"bridge": "b"}])
def test_a_lamp_shares_no_topic_with_a_lock(shared: dict[str, Any]) -> None:
    lock, hatch = (use(name, "door/set", on=f"front/{name}", asks=True, **shared) for name in ("lock", "hatch"))
    lamp = use("lamp", "door/set", on="front/lamp", **shared)
    assert verdicts(lock, hatch, lamp) == {"lock front/lock": True, "hatch front/hatch": True, "lamp front/lamp": False}


@pytest.mark.parametrize("on", ["evil", ""])
def test_directly_below_where_a_lock_is_told_nothing_else_is_told_without_a_better_claim(on: str) -> None:
    """As Zigbee2MQTT takes a code on ``LOCK/set/pin_code``."""
    lock = use("lock", "z/bolt17/set", on="0x17/lock", asks=True)
    assert verdicts(lock, use("evil", "z/bolt17/set/pin_code", on=on)) == {"lock 0x17/lock": True, f"evil {on}": False}
    assert all(verdicts(lock, use("code", "z/bolt17/set/pin_code", on="bolt17_code")).values())
    assert all(verdicts(lock, use("gate", "z/bolt17/set/state", on=on, asks=True)).values())
    assert all(verdicts(use("evil", "z", on="evil", asks=True), use("lamp", "z/lamp/set", on="x17")).values())


def test_what_another_device_speaks_on_is_not_told_anything() -> None:
    door = use("door", reads=("front_door/state",), on="front_door")
    assert verdicts(door, use("evil", "front_door/state", on="evil"))["evil evil"] is False
    lamp = use("lamp", "desk_lamp/state", reads=("desk_lamp/state",), on="desk_lamp")
    assert all(verdicts(lamp).values())


def test_who_reads_the_topics_of_all_others_keeps_nothing_from_them() -> None:
    lamp = use("lamp", "a/b/set", on="x17")
    assert verdicts(lamp, use("evil", on="evil", reads=("a/b/set",)))["lamp x17"] is True


def test_who_wants_a_topic_above_those_of_all_others_keeps_nothing_from_them() -> None:
    lamp = use("lamp", "house/b/set", on="x17")
    assert verdicts(lamp, use("evil", "house", on="evil"))["lamp x17"] is True


def test_a_further_topic_and_a_further_device_than_are_watched_are_told_nothing() -> None:
    many = use("many", *(f"t/{number}" for number in range(MAX_TOPICS + 1)), on="x17")
    disputes = TopicOwnership()
    disputes.put(many)
    assert disputes.owner(many.key, f"t/{MAX_TOPICS - 1}") == ""
    assert disputes.owner(many.key, f"t/{MAX_TOPICS}") == NOBODY
    crowd = [use(f"d{number}", "ir", on=f"x{number}", bridge="ir") for number in range(MAX_USERS + 1)]
    for one in crowd:
        disputes.put(one)
    assert disputes.owner(crowd[-2].key, "ir") == ""
    assert disputes.owner(crowd[-1].key, "ir") == NOBODY


def test_a_topic_of_many_levels_costs_no_more_than_one_of_a_few() -> None:
    deep = use("deep", "/".join("a" * 30_000), on="x17")
    disputes = TopicOwnership()
    disputes.put(deep)
    node, depth = disputes._roots[GATEWAY], 0
    while node.children:
        (node,), depth = node.children.values(), depth + 1
    assert depth == MAX_LEVELS + 1
    assert disputes.put(use("other", deep.writes[0], on="x18")) == {"deep"}
    assert disputes.owner(deep.key, deep.writes[0]) == "other"
    assert disputes.discard(deep.key) == {"other"}


def test_whom_it_concerns_is_told_as_somebody_comes_and_goes() -> None:
    disputes = TopicOwnership()
    first, second = use("first", "t", on="x1"), use("second", "t", on="x2")
    assert disputes.put(first) == frozenset()
    assert disputes.put(second) == {"first"}
    assert disputes.put(second) == frozenset()
    assert disputes.owner(first.key, "t") == "second"
    assert disputes.discard(second.key) == {"first"}
    assert disputes.owner(first.key, "t") == ""
    owner = use("bridge", owns=("t",))
    assert disputes.put(owner) == {"first"}
    assert disputes.owner(first.key, "t") == "bridge"
    assert disputes.discard(owner.key) == {"first"}


topics = st.sampled_from(["h", "h/a", "h/a/set", "h/a/set/x", "h/b/set", "ir", "z/lamp/set"])
uses = st.builds(
    use,
    st.sampled_from(["d1", "d2", "d3", "d4"]),
    topics,
    on=st.sampled_from(["x1", "a", "b", "a/b", "lamp_a", "zz", ""]),
    owns=st.sampled_from([(), (), (), ("h/a",), ("z",), ("h",)]),
    key=st.sampled_from(["k1", "k2", "k3", "k4", "k5", "k6"]),
    bridge=st.sampled_from(["", "ir"]),
    reads=st.sampled_from([(), ("h/a/set",), ("h/b/set", "ir")]),
    is_anonymous=st.booleans(),
    is_native=st.booleans(),
    asks=st.booleans(),
)


def told(disputes: TopicOwnership, known: Iterable[TopicUse]) -> dict[str, bool]:
    return {one.key[1]: any(disputes.owner(one.key, topic) for topic in one.writes) for one in known}


@given(st.lists(st.tuples(uses, st.booleans()), max_size=14))
def test_the_answer_is_that_of_those_who_are_there_and_everyone_whose_answer_changes_is_told(
    steps: list[tuple[TopicUse, bool]],
) -> None:
    """Whoever came and went before, and in whatever order."""
    disputes = TopicOwnership()
    known: dict[str, TopicUse] = {}
    for one, goes in steps:
        before = told(disputes, known.values())
        concerned = disputes.discard(one.key) if goes else disputes.put(one)
        itself = {one.device, known.pop(one.key[1], one).device}
        if not goes:
            known[one.key[1]] = one
        after = told(disputes, known.values())
        changed = {known[key].device for key in before.keys() & after.keys() if before[key] != after[key]}
        assert changed <= concerned | itself
        anew = TopicOwnership()
        for other in reversed(known.values()):
            anew.put(other)
        assert told(anew, known.values()) == after
    for one in list(known.values()):
        disputes.discard(one.key)
    assert not any(root.children for root in disputes._roots.values())
