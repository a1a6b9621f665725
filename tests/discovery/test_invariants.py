"""Whatever is announced, taken back, said and awaited: what must always hold of the index."""

from itertools import count
from typing import Literal, TypeAlias

from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of

from homebot.devices import Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.part import Capability, Part
from homebot.devices.query.terms import And
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex
from homebot.discovery.record import entry_record, read_entry
from homebot.messages import Time

Kind: TypeAlias = Literal["updated", "removed"]

identifiers = st.lists(
    st.sampled_from(
        ["mac:000000000001", "mac:000000000002", "eui64:0000000000000003", "id:one", "id:mqtt", "id:twelve"]
    ),
    max_size=3,
    unique=True,
)
announcements = st.tuples(
    st.just("announce"),
    st.integers(0, 6),
    st.sampled_from(["homeassistant", "zigbee2mqtt", "homie", ""]),
    identifiers,
    st.sampled_from(["lamp", "Lamp", "ümlaut\0<b>", ""]),
    st.sampled_from(["a/set", "b/set", ""]),
    st.booleans(),
)
other = st.tuples(
    st.sampled_from(["remove", "live", "kept", "online", "offline", "wait", "wait long", "forget"]),
    st.integers(0, 6),
    st.sampled_from(["homeassistant", "zigbee2mqtt", "homie", ""]),
)


def sighting(step: tuple[object, ...], at: float, kind: Kind = "updated") -> Sighting:
    _, number, convention, ids, name, topic, confirmed = step
    part = Part(
        id="p",
        service_type="light",
        capabilities=(Capability(name="on_off", settable=True),),
        writes=(str(topic),) if topic else (),
    )
    return sighting_of(
        f"{convention}:{number}",
        part,
        kind=kind,
        name=str(name),
        convention=str(convention),
        identifiers=tuple(ids) if isinstance(ids, list) else (),
        confirmed=bool(confirmed),
        at=at,
        lasts=50.0,
    )


def report(key: str, at: float, *, what: str) -> Report:
    capability = REACHABLE if what in {"online", "offline"} else "on_off"
    reading = Reading(
        part="" if capability == REACHABLE else "p", capability=capability, value=Value.of(what in {"online", "live"})
    )
    return Report(
        gateway="mqtt",
        key=key,
        readings=(reading,),
        address="said",
        retained=what == "kept",
        received_at=Time.from_seconds(at),
    )


@given(st.lists(st.one_of(announcements, other), max_size=40))
def test_every_announcement_belongs_to_one_device_and_every_change_tells_a_consistent_story(
    steps: list[tuple[object, ...]],
) -> None:
    index = DeviceIndex(forget_after=200.0)
    there: set[str] = set()
    clock = count(0, 3)
    now = 0.0
    for step in steps:
        now = max(now, float(next(clock)))
        what, number = str(step[0]), step[1]
        key = f"{step[2]}:{number}"
        if what == "announce":
            index.observe(sighting(step, now))
        elif what == "remove":
            index.observe(sighting((what, number, step[2], [], "", "", True), now, "removed"))
        elif what == "forget":
            index.forget(next(iter(sorted(there)), ""), now)
        elif what.startswith("wait"):
            now += 300.0 if what == "wait long" else 40.0
        else:
            index.report(report(key, now, what=what))
        index.expire(now)
        last = index.sequence
        for change in index.pop_changes():
            assert change.sequence == last + 1
            last = change.sequence
            assert (change.kind == "appeared") == (change.device.id not in there)
            there.add(change.device.id)
            if change.kind == "removed":
                there.remove(change.device.id)
        check(index, there)


def check(index: DeviceIndex, there: set[str]) -> None:
    """The devices are those that were told of; each is made of what is bound together, and of nothing else."""
    devices = index.devices()
    assert {one.id for one in devices} == there == index.find(And(()))
    groups = {frozenset(entry.sources) for one in devices if (entry := index.entry(one.id)) is not None}
    assert groups == set(index._merger.identities.groups(index.table.sources))
    assert sum(len(one) for one in groups) == len(index.table.sources) == len(index.table.owners)
    for device in devices:
        assert device.endpoints
        assert len({one.id for one in device.parts}) == len(device.parts)
        routes = [route for one in device.parts for route in one.routes]
        assert len(set(map(str, routes))) == len(routes)
        entry = index.entry(device.id)
        assert entry is not None
        again = read_entry(device.id, entry_record(entry))
        assert list(again.sources) == list(entry.sources)


@given(
    st.lists(announcements, max_size=8, unique_by=lambda step: (step[1], step[2])).flatmap(
        lambda steps: st.tuples(st.just(steps), st.permutations(steps))
    )
)
def test_the_order_of_announcements_makes_no_difference_to_who_is_who(
    orders: tuple[list[tuple[object, ...]], list[tuple[object, ...]]],
) -> None:
    """But for who is called what."""
    made = []
    for order in orders:
        index = DeviceIndex(forget_after=200.0)
        for step in order:
            index.observe(sighting(step, 0.0))
        made.append({frozenset(entry.sources) for entry in index.table.entries.values()})
    assert made[0] == made[1]
