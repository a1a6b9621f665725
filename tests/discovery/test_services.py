"""What the directory answers, and what it tells those who follow; in virtual time."""

import anyio
import anyio.lowlevel
import pytest
from tests.discovery.announcements import announce, part_of, tell
from tests.discovery.directory_house import directory

from homebot.clock import LoopClock, ManualClock
from homebot.devices import Follow, KeyValue, Sighting, StateChange, names, services
from homebot.devices.gateway_messages import Report
from homebot.devices.health import GetHealth
from homebot.devices.query.term_messages import QueryTerm, query_terms
from homebot.discovery import Directory, DirectorySettings
from homebot.discovery.index import DeviceIndex
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.services import DirectoryServices
from homebot.errors import UsageError
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.words.house_queries import WordsQuery
from homebot.words.queries import parse_query

pytestmark = pytest.mark.virtual_time


@pytest.fixture
def lamp() -> Sighting:
    light = part_of("light", "on_off", "level", id="l", writes=("a/set",))
    return announce("l", light, ids=("id:lamp-4711",), name="Desk lamp", area="Study", at=1.0, confirmed=True)


async def test_a_query_is_answered_with_reasons_in_portions(lamp: Sighting) -> None:
    async with directory() as house:
        others = [
            lamp.model_copy(update={"key": f"k{one}", "identifiers": (f"id:other-{one}",), "name": f"Other {one}"})
            for one in range(4)
        ]
        await house.hears(lamp, *others, tell(lamp, "on_off", True, part="l"))
        ask = house.asker.create_client(services.QueryDevices, names.QUERY_DEVICES)

        found = await ask.call(services.QueryDevices.Request(query=query_terms(parse_query("on lights"))))
        assert (found.success, found.total) == (True, 1)
        assert [(one.device.id, one.reasons) for one in found.results] == [
            ("desk_lamp", ("it is a light", "on_off is true", "it reported recently"))
        ]
        some = await ask.call(services.QueryDevices.Request(query=query_terms(parse_query("light")), offset=1, limit=2))
        assert (some.total, [one.device.id for one in some.results]) == (5, ["other_0", "other_1"])
        assert len((await ask.call(services.QueryDevices.Request())).results) == 5


async def test_a_query_that_is_not_understood_is_answered_with_the_reason() -> None:
    async with directory() as house:
        answer = await house.asker.create_client(services.QueryDevices, names.QUERY_DEVICES).call(
            services.QueryDevices.Request(query=(QueryTerm(kind="not"),))
        )
        assert not answer.success
        assert "ends after term 1" in answer.message


async def test_devices_are_found_by_any_word_for_what_they_are(lamp: Sighting) -> None:
    async with directory() as house:
        await house.hears(lamp)
        find = house.asker.create_client(services.FindDevices, names.FIND_DEVICES)
        for word in ("light", "lights", "lamp", ""):
            assert [one.id for one in (await find.call(services.FindDevices.Request(service_type=word))).devices] == [
                "desk_lamp"
            ]


async def test_devices_are_found_by_their_ids(lamp: Sighting) -> None:
    """Of those asked for, each once and sorted; with a type only those that fit it as well."""
    async with directory() as house:
        other = lamp.model_copy(update={"key": "k", "identifiers": ("id:other",), "name": "Other"})
        await house.hears(lamp, other)
        find = house.asker.create_client(services.FindDevices, names.FIND_DEVICES)

        async def found(*ids: str, service_type: str = "") -> list[str]:
            answer = await find.call(services.FindDevices.Request(ids=ids, service_type=service_type))
            return [device.id for device in answer.devices]

        assert await found("other") == ["other"]
        assert await found("other", "nobody", "desk_lamp", "other") == ["desk_lamp", "other"]
        assert await found("nobody") == []
        assert await found("other", service_type="light") == ["other"]
        assert await found("other", service_type="lock") == []


async def test_devices_are_listed_in_short_and_in_slices(lamp: Sighting) -> None:
    """For screens, and for agents that pay for each byte."""
    async with directory() as house:
        others = [
            lamp.model_copy(update={"key": f"k{one}", "identifiers": (f"id:other-{one}",), "name": f"Other {one}"})
            for one in range(210)
        ]
        lamp = lamp.model_copy(update={"metadata": (*lamp.metadata, KeyValue(key="position", value="6,1.5"))})
        news = [tell(lamp, *value, part="l", address=value[0], at=7.0) for value in (("on_off", True), ("level", 40.0))]
        await house.hears(lamp, *others, tell(lamp, "on_off", False, part="l"), *news)
        ask = house.asker.create_client(services.ListDevices, names.LIST_DEVICES)

        (found,) = (await ask.call(services.ListDevices.Request(ids=("desk_lamp",)))).devices
        assert found.model_dump(mode="json") == {
            "id": "desk_lamp",
            "name": "Desk lamp",
            "type": "light",
            "room": "Study",
            "freshness": "fresh",
            "is_reachable": True,
            "waits": False,
            "states": [
                {"part": "l", "capability": "on_off", "value": True, "since": {"sec": 7, "nanosec": 0}},
                {"part": "l", "capability": "level", "value": 40.0, "since": {"sec": 0, "nanosec": 0}},
            ],
            "units": [],
            "position": [6.0, 1.5],
            "settable": ["on_off", "level"],
            "tags": [],
            "asks_first": [],
            "codes": [],
            "kind": "",
            "may_act": True,
        }
        first = await ask.call(services.ListDevices.Request(limit=1000))
        rest = await ask.call(services.ListDevices.Request(offset=200))
        assert (len(first.devices), len(rest.devices), first.total, rest.total) == (200, 11, 211, 211)
        assert len({one.id for one in (*first.devices, *rest.devices)}) == 211
        wrong = await ask.call(services.ListDevices.Request(query=query_terms(parse_query("in studi"))))
        assert (wrong.success, wrong.devices) == (False, ())


async def test_others_get_turns_while_an_answer_waits_for_hundreds_of_new_devices() -> None:
    """One for every twenty of them at least; the answer holds them all."""
    count = 300
    async with directory() as house, anyio.create_task_group() as tasks:
        find = house.asker.create_client(services.FindDevices, names.FIND_DEVICES)
        turns = 0

        async def take_turns() -> None:
            nonlocal turns
            while True:
                await anyio.lowlevel.checkpoint()
                turns += 1

        for number in range(count):
            lamp = announce(f"light/lamp{number}", part_of(), ids=(f"mac:{number:012x}",), name=f"Lamp {number}")
            house.directory.index.observe(lamp, 0.0)
        tasks.start_soon(take_turns)
        response = await find.call(services.FindDevices.Request(query=query_terms(parse_query("lamp"))))
        assert len(response.devices) == count
        assert turns >= count / 20
        tasks.cancel_scope.cancel()


async def test_who_asks_in_a_flood_of_large_devices_is_answered_before_it_ends() -> None:
    """Both to announce them and to make them findable takes long; an answer gets as much time as the flood."""
    clock = ManualClock()
    graph, index = Graph(clock), DeviceIndex(forget_after=60.0)

    def publish(at_most: int) -> bool:
        clock.advance(0.006)
        return len(index.pop_changes(at_most)) >= at_most

    async with (
        Node(graph, "discovery") as node,
        Node(graph, "asker") as asker,
        anyio.create_task_group() as tasks,
    ):
        DirectoryServices(node, index, IndexPersistence(node, index, None), publish).register()
        find = asker.create_client(services.FindDevices, names.FIND_DEVICES)
        answers: list[services.FindDevicesResponse] = []

        async def ask() -> None:
            answers.append(await find.call(services.FindDevicesRequest()))

        for turn in range(100):
            for number in range(15):
                name = f"{turn}-{number}"
                index.observe(announce(f"lamp/{name}", part_of(), ids=(f"id:{name}",), name=name), 0.0)
            clock.advance(0.03)
            if turn == 20:
                tasks.start_soon(ask)
            await anyio.lowlevel.checkpoint()
            if answers:
                break
        assert answers
        tasks.cancel_scope.cancel()


async def test_a_late_asker_is_told_what_happened_since(lamp: Sighting) -> None:
    async with directory() as house:
        ask = house.asker.create_client(services.GetChanges, names.GET_CHANGES)
        before = (await ask.call(services.GetChanges.Request(since=0))).sequence
        await house.hears(lamp)
        await house.hears(lamp.model_copy(update={"name": "Reading lamp"}))
        since = await ask.call(services.GetChanges.Request(since=before))
        assert since.complete
        assert [one.kind for one in since.changes] == ["appeared", "changed"]
        assert since.sequence == since.changes[-1].sequence
        assert not (await ask.call(services.GetChanges.Request(since=-1))).complete
        assert not (await ask.call(services.GetChanges.Request(since=since.sequence + 1))).complete
        assert (await ask.call(services.GetChanges.Request(since=since.sequence))).changes == ()


async def test_a_forgotten_device_is_gone_until_it_speaks(lamp: Sighting) -> None:
    async with directory() as house:
        await house.hears(lamp)
        forget = house.asker.create_client(services.ForgetDevice, names.FORGET_DEVICE)
        answer = await forget.call(services.ForgetDevice.Request(device="desk_lamp"))
        assert [(one.gateway, one.topic) for one in answer.announced_on] == [("mqtt", "homeassistant/l/config")]
        await house.hears(lamp.model_copy(update={"confirmed": False}))
        assert len(house.directory.index) == 0
        await house.hears(tell(lamp, "on_off", True, part="l"))
        assert [one.id for one in house.directory.index.devices()] == ["desk_lamp"]
        assert not (await forget.call(services.ForgetDevice.Request(device="nobody"))).success


async def test_the_owner_splits_a_device_and_merges_it_again() -> None:
    async with directory() as house:
        own = announce("z", part_of(id="z"), convention="zigbee2mqtt", ids=("eui64:00158d0001abcdef",), name="Z lamp")
        foreign = announce("l", part_of(id="l"), ids=("eui64:00158d0001abcdef",), name="L lamp")
        await house.hears(own, foreign)
        split = house.asker.create_client(services.SplitDevice, names.SPLIT_DEVICE)
        merge = house.asker.create_client(services.MergeDevices, names.MERGE_DEVICES)
        assert (await split.call(services.SplitDevice.Request(device="z_lamp"))).devices == ("z_lamp", "l_lamp")
        again = await split.call(services.SplitDevice.Request(device="z_lamp"))
        assert (again.success, again.message) == (
            False,
            "a split of z_lamp was refused: nothing was merged into it",
        )
        merged = await merge.call(services.MergeDevices.Request(devices=("l_lamp", "z_lamp")))
        assert (merged.success, merged.device) == (True, "z_lamp")
        assert [one.id for one in house.directory.index.devices()] == ["z_lamp"]
        alone = await merge.call(services.MergeDevices.Request(devices=("z_lamp",)))
        assert (alone.success, alone.message) == (False, "a merge was refused: it takes two different devices")


async def test_health_counts(lamp: Sighting) -> None:
    async with directory() as house:
        await house.hears(lamp, tell(lamp, "on_off", True, part="unknown"))
        health = await house.asker.create_client(GetHealth, names.DISCOVERY_HEALTH).call(GetHealth.Request())
        counts = {one.name: one.count for one in health.counts}
        assert (counts["devices"], counts["unknown_parts"], counts["index_file_failures"]) == (1, 1, 0)


async def test_new_values_are_told_only_while_somebody_listens(lamp: Sighting) -> None:
    async with directory() as house:
        await house.hears(lamp, tell(lamp, "level", 10.0, part="l"))
        states = house.asker.create_subscription(StateChange, names.DEVICE_STATES, qos_profile=10)
        await house.hears(tell(lamp, "level", 20.0, part="l", at=2.0))
        change = states.take()
        assert change is not None
        (state,) = change.states
        assert (change.device, state.part, state.value.plain()) == ("desk_lamp", "l", 20.0)


async def test_a_device_that_comes_to_fit_a_live_query_appears_and_one_that_does_not_goes(lamp: Sighting) -> None:
    """By its values, its room and its life."""
    async with directory() as house:
        await house.hears(lamp, tell(lamp, "on_off", False, part="l"))
        heard: list[tuple[str, str]] = []
        follow = Follow(house.asker, words=WordsQuery("on lights in study"))

        async def read() -> None:
            async for change in follow:
                heard.append((change.kind, change.why))  # noqa: PERF401 - as they come

        house.asker.create_task(read)
        await anyio.sleep(0.01)
        assert heard == []
        await house.hears(tell(lamp, "on_off", True, part="l", at=2.0))
        await house.hears(tell(lamp, "level", 50.0, part="l", at=3.0))
        await house.hears(tell(lamp, "on_off", False, part="l", at=4.0))
        await house.hears(tell(lamp, "on_off", True, part="l", at=5.0))
        await house.hears(lamp.model_copy(update={"area": "Hall"}))
        assert heard == [
            ("appeared", "its on_off is True now"),
            ("removed", "it no longer matches the query"),
            ("appeared", "its on_off is True now"),
            ("removed", "its description changed"),
        ]
        follow.close()


async def test_a_live_query_that_is_not_understood_is_refused_at_once() -> None:
    async with directory() as house:
        with pytest.raises(UsageError, match="never closed"):
            Follow(house.asker, words=WordsQuery("(light"))


async def test_a_restarted_directory_knows_what_devices_told(lamp: Sighting) -> None:
    """Gateways keep announcements and reports for late joiners; the one is read before the other."""
    graph, own = Graph(LoopClock(0.0)), names.GatewayNames("mqtt")
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    async with Node(graph, "mqtt", namespace="/gateway") as gateway:
        gateway.create_publisher(Report, own.readings, kept).publish(tell(lamp, "level", 30.0, part="l"))
        gateway.create_publisher(Sighting, own.received_topics, kept).publish(lamp)
        async with Node(graph, "discovery") as node, anyio.create_task_group() as tasks:
            made = Directory(node, DirectorySettings())
            await tasks.start(made.serve)
            (device,) = made.index.devices()
            tasks.cancel_scope.cancel()
    assert [one.value.plain() for one in device.states] == [30.0]
