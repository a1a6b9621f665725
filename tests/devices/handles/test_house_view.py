"""The node's view of the house, as its live queries report it; in virtual time."""

import asyncio
from typing import Any, Literal, TypeAlias

import anyio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.devices.handles.conftest import House, device, part

from homebot.devices import Device, Follow
from homebot.devices.device import ChangeKind
from homebot.devices.follow import LiveQuery
from homebot.devices.handles import Light
from homebot.graph import Graph, Node
from homebot.testing import VirtualTimeLoop
from homebot.words.house_queries import WordsQuery

LAMP, PLUG = device("lamp", part("light", "on_off")), device("lamp", part("plug", "on_off"))


async def read(query: LiveQuery[Any]) -> list[Any]:
    """Return the changes of the next moment."""
    found: list[Any] = []
    with anyio.move_on_after(0.1):
        async for change in query:
            found.append(change)  # noqa: PERF401  # it is cut short
    return found


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ([("appeared", LAMP), ("changed", LAMP), ("stale", LAMP), ("returned", LAMP), ("removed", LAMP)], None),
        ([("stale", LAMP), ("changed", LAMP)], ["appeared", "changed"]),
        ([("removed", LAMP)], [""]),
        ([("appeared", PLUG)], [""]),
        (
            [("appeared", LAMP), ("changed", PLUG), ("changed", PLUG), ("changed", LAMP)],
            ["appeared", "removed", "", "appeared"],
        ),
    ],
    ids=["as they are", "first appeared", "never present", "another type", "another type for a while"],
)
async def test_a_reader_gets_appeared_first_and_removed_last(
    house: House, changes: list[tuple[ChangeKind, Device]], reported: list[str] | None
) -> None:
    query = Follow(house.node, "light")
    await read(query)
    found = []
    for kind, changed in changes:
        if kind == "removed":
            house.has(changed)
        house.tells(kind, changed)
        found.append("".join(change.kind for change in await read(query)))
    assert found == ([kind for kind, _ in changes] if reported is None else reported)


@pytest.mark.virtual_time
async def test_a_value_that_changed_while_the_directory_was_away_is_reported(house: House) -> None:
    lamp = part("light", "on_off")
    house.has(device("a", lamp, on_off=True), device("b", lamp, on_off=False))
    lit = house.devices.follow(Light, on=True)
    assert [(change.kind, change.handle.id) for change in await read(lit)] == [("appeared", "a")]
    house.has(device("a", lamp, on_off=False), device("b", lamp, on_off=True))
    house.restart_directory()
    assert {(change.kind, change.handle.id) for change in await read(lit)} == {("removed", "a"), ("appeared", "b")}


@pytest.mark.virtual_time
async def test_all_queries_of_a_node_share_one_view(house: House) -> None:
    """The number of subscriptions does not grow with the number of queries, and a later query gets the same house."""
    house.has(LAMP)
    first = Follow(house.node)
    assert len(await read(first)) == 1
    before = house.graph.get_endpoints(node="/app")
    (lamp,) = await house.devices.find(Light)
    later: list[LiveQuery[Any]] = [
        Follow(house.node, "light"),
        house.devices.follow(Light),
        Follow(house.node, words=WordsQuery("on lights")),
    ]
    assert [len(await read(query)) for query in later] == [1, 1, 0]
    house.says("lamp", "on_off", True)
    assert [len(await read(query)) for query in later] == [0, 1, 1]
    assert lamp.on
    assert house.graph.get_endpoints(node="/app") == before


Event: TypeAlias = tuple[Literal["appeared", "changed", "stale", "removed"], str, Literal["light", "plug"]]
events = st.tuples(
    st.sampled_from(["appeared", "changed", "stale", "removed"]),
    st.sampled_from("abc"),
    st.sampled_from(["light", "plug"]),
)


@given(st.lists(st.tuples(events, st.booleans(), st.booleans()), max_size=12))
def test_a_reader_gets_a_consistent_story(steps: list[tuple[Event, bool, bool]]) -> None:
    """No device appears twice or is removed before it appeared, and at the end the reader knows those that match."""

    async def tell_story() -> None:
        graph = Graph()
        async with Node(graph, "app") as node, Node(graph, "discovery") as directory:
            house = House(graph, node, directory)
            query = Follow(node, "light")
            present: set[str] = set()
            expected: dict[str, str] = {}
            for (kind, device_id, service_type), is_restarted, is_read in [
                *steps,
                (("stale", "z", "light"), True, True),
            ]:
                changed = device(device_id, part(service_type, "on_off"))
                house.has(changed)
                house.tells(kind, changed)
                expected[device_id] = service_type
                if kind == "removed":
                    del expected[device_id]
                if is_restarted:
                    house.restart_directory()
                for change in await read(query) if is_read else ():
                    assert (change.kind == "appeared") == (change.device.id not in present)
                    (present.discard if change.kind == "removed" else present.add)(change.device.id)
            assert present == {one for one, service_type in expected.items() if service_type == "light"}

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(tell_story())
