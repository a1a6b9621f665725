"""The gateway to a directory of things: pages, events, floods, passwords, and things that vanish."""

import select
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import anyio
import anyio.abc
import anyio.lowlevel
import pytest
from pydantic import ValidationError
from tests.gateways.served import served
from tests.patience import PATIENCE, until
from tests.things.directory import ThingDirectoryServer
from tests.things.thing import ServedThing

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.value import PlainValue
from homebot.gateways.announced.device_runner import LISTED_WITHIN
from homebot.graph import Graph, Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.things.directory import ThingDirectoryGateway, ThingDirectorySettings
from homebot.integrations.things.formats.parse import CONTEXT
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import listen


def description(number: int, **changes: Any) -> dict[str, Any]:
    form = {"href": f"http://127.0.0.1:9/{number}"}
    return {
        "@context": CONTEXT,
        "id": f"urn:dev:lamp:{number}",
        "title": f"Lamp {number}",
        "securityDefinitions": {"open": {"scheme": "nosec"}},
        "security": "open",
        "properties": {"on": {"type": "boolean", "@type": "OnOffProperty", "forms": [form]}},
    } | changes


@asynccontextmanager
async def gateway(url: str, **settings: object) -> AsyncIterator[tuple[ThingDirectoryGateway, Node]]:
    graph = Graph()
    async with Node(graph, "things", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        found = ThingDirectoryGateway(node, ThingDirectorySettings.model_validate({"url": url, **settings}))
        async with running(found):
            yield found, watcher


async def test_all_pages_of_the_list_are_read() -> None:
    directory = ThingDirectoryServer(page=7)
    for number in range(30):
        directory.register(description(number))
    async with served(directory), gateway(directory.url) as (found, _):
        await until(lambda: len(found.devices.keys) == 30)


async def test_changes_come_as_events() -> None:
    directory = ThingDirectoryServer()
    async with served(directory), gateway(directory.url) as (found, watcher):
        sightings = listen(watcher, Sighting, found.names.received_topics)
        directory.register(description(1))
        await until(lambda: len(found.devices.keys) == 1)
        directory.register(description(1, title="Other"))
        with anyio.fail_after(PATIENCE):
            while (await sightings.receive()).name != "Other":
                pass
        directory.delete("urn:dev:lamp:1")
        await until(lambda: found.devices.keys == ())


async def test_a_directory_without_events_is_read_again() -> None:
    directory = ThingDirectoryServer(has_events=False)
    directory.register(description(1))
    async with served(directory), gateway(directory.url, list_every=1.0) as (found, _):
        await until(lambda: found.devices.keys == ("urn:dev:lamp:1",))
        directory.delete("urn:dev:lamp:1")
        directory.register(description(2))
        await until(lambda: found.devices.keys == ("urn:dev:lamp:2",))


async def test_a_malformed_description_is_counted_once_and_the_others_are_listed() -> None:
    directory = ThingDirectoryServer(has_events=False)
    directory.register(description(1, properties={"on": {"forms": []}}))
    directory.register(description(2))
    directory.things["x"] = {"title": "has no id"}
    async with served(directory), gateway(directory.url, list_every=1.0) as (found, _):
        await until(lambda: found.devices.keys == ("urn:dev:lamp:2",))
        await until(lambda: found.devices.counters.rejected >= 3)
    assert found.devices.counters.rejected <= 6


async def test_a_thing_that_speaks_only_coap_says_what_to_do() -> None:
    form = {"href": "coap://127.0.0.1/on"}
    directory = ThingDirectoryServer(has_events=False)
    directory.register(
        description(1, properties={"on": {"type": "boolean", "@type": "OnOffProperty", "forms": [form]}})
    )
    async with served(directory), gateway(directory.url) as (found, watcher):
        sighting = await listen(watcher, Sighting, found.names.received_topics).receive()
    facts = {one.key: one.value for one in sighting.metadata}
    assert facts["unusable"].startswith("its addresses are of coap, not of HTTP; the gateway coap can use it")


async def test_a_description_that_is_too_long_is_refused_and_the_others_are_listed() -> None:
    directory = ThingDirectoryServer(has_events=False)
    directory.register(description(1, description="x" * 300_000))
    directory.register(description(2))
    async with served(directory), gateway(directory.url) as (found, _):
        await until(lambda: found.devices.keys == ("urn:dev:lamp:2",))
        assert found.devices.counters.rejected == 1


async def test_ten_thousand_fake_things_take_no_more_room_than_is_allowed() -> None:
    """The directory stays usable, and one that was known before goes on."""
    lamp = ServedThing(SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall"), lambda _: None)
    lamp.begin(DeviceState(text="off"), has_power=True)
    directory = ThingDirectoryServer(page=500)
    async with served(directory, lamp):
        directory.register(lamp.description())
        key = str(lamp.description()["id"])
        async with gateway(directory.url, max_devices=50) as (found, watcher):
            await until(lambda: key in found.devices.keys)
            for number in range(10_000):
                directory.things[f"urn:dev:lamp:{number}"] = description(number)
            directory.delete("urn:dev:lamp:9999")
            directory.server.peers[0].send(b'event: thing_created\ndata: {"id": "urn:dev:lamp:1"}')
            session = found._session
            assert session is not None
            session._lists_soon.set()
            for number in range(300):
                directory.things[f"urn:dev:lamp:{number}"] = description(number, title="Again")
                directory.server.peers[0].send(b'event: thing_updated\ndata: {"id": "urn:dev:lamp:%d"}' % number)
                await anyio.lowlevel.checkpoint()
            await until(lambda: found.devices.counters.devices_refused > 0)
            assert len(session._known) <= 50
            assert key in found.devices.keys
            reports = listen(watcher, GatewayState, found.names.state)
            assert (await reports.receive()).state == "active"


async def test_a_directory_that_wants_a_token_gets_it_and_without_one_is_unavailable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("DIRECTORY_TOKEN", "sesame")
    directory = ThingDirectoryServer(token="sesame")
    directory.register(description(1))
    async with served(directory):
        login = {"host": "127.0.0.1", "scheme": "bearer", "password_env": "DIRECTORY_TOKEN"}
        async with gateway(directory.url, credentials=[login]) as (found, _):
            await until(lambda: len(found.devices.keys) == 1)
        async with gateway(directory.url) as (found, watcher):
            state = await listen(watcher, GatewayState, found.names.state).receive()
            assert state.state == "unavailable"
            assert "password" in state.reason


async def test_a_thing_that_wants_a_password_is_named_by_the_doctor() -> None:
    lamp = ServedThing(SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall"), lambda _: None, token="sesame")
    lamp.begin(DeviceState(text="off"), has_power=True)
    directory = ThingDirectoryServer()
    async with served(lamp), served(directory):
        directory.register(lamp.description())
        async with gateway(directory.url) as (found, watcher):
            reports = listen(watcher, Report, found.names.readings)
            with anyio.fail_after(PATIENCE):
                while reachable(await reports.receive()) is not False:
                    pass
            health = watcher.create_client(GetHealth, found.names.health)
            (trouble,) = (await health.call(HealthRequest())).troubles
    assert trouble.startswith("Hall: ")
    assert "password" in trouble


def reachable(report: Report) -> PlainValue:
    """Return what *report* says of whether a device can be reached; None for nothing."""
    return next((one.value.plain() for one in report.readings if one.capability == REACHABLE), None)


async def test_things_stay_and_are_used_while_the_directory_is_away() -> None:
    lamp = ServedThing(SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall"), lambda _: None)
    lamp.begin(DeviceState(text="off"), has_power=True)
    directory = ThingDirectoryServer()
    async with served(lamp), anyio.create_task_group() as tasks:
        async with served(directory):
            directory.register(lamp.description())
            found, watcher = await tasks.start(_kept_running, directory.url)
            await until(lambda: len(lamp.server.peers) == 3)
        states = listen(watcher, GatewayState, found.names.state)
        with anyio.fail_after(PATIENCE):
            while (await states.receive()).state != "unavailable":
                pass
        assert len(found.devices.keys) == 1
        assert len(lamp.server.peers) == 3
        tasks.cancel_scope.cancel()


async def _kept_running(url: str, *, task_status: anyio.abc.TaskStatus[tuple[ThingDirectoryGateway, Node]]) -> None:
    async with gateway(url) as both:
        task_status.started(both)
        await anyio.sleep_forever()


def is_given_up(stream: anyio.abc.SocketStream) -> bool:
    """Return whether its client has closed it, which a server reads later."""
    poll = select.poll()
    poll.register(stream.extra(anyio.abc.SocketAttribute.raw_socket), select.POLLRDHUP)  # noqa: S610 - not Django
    return poll.poll(0) != []


async def test_a_directory_of_many_things_is_connected_to_twenty_at_a_time(pass_time: Callable[[float], None]) -> None:
    """The things accept connections, and never answer."""
    most = total = 0
    streams: set[anyio.abc.SocketStream] = set()

    async def on_connection(stream: anyio.abc.SocketStream) -> None:
        nonlocal most, total
        total += 1
        streams.add(stream)
        most = max(most, sum(not is_given_up(one) for one in streams))
        async with stream:
            async for _ in stream:
                pass
        streams.remove(stream)

    directory = ThingDirectoryServer(has_events=False, page=100)
    silent = await anyio.create_tcp_listener(local_host="127.0.0.1", local_port=0)
    port = silent.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - not Django
    for number in range(200):
        form = {"href": f"http://127.0.0.1:{port}/{number}"}
        on = {"type": "boolean", "@type": "OnOffProperty", "forms": [form]}
        directory.things[f"urn:dev:lamp:{number}"] = description(number, properties={"on": on})
    async with silent, served(directory), anyio.create_task_group() as tasks:
        tasks.start_soon(silent.serve, on_connection)
        async with gateway(directory.url) as (found, _):
            await until(lambda: total >= 20)
            pass_time(LISTED_WITHIN)
            await until(lambda: len(found.devices.keys) == 200)
            assert most <= 20
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("url", ["", "ftp://x", "http://", "http://ann:pw@x", "http://x:99999", "http://x/?y=1"])
def test_an_address_that_is_none_is_refused_with_the_configuration(url: str) -> None:
    with pytest.raises(ValidationError, match="url"):
        ThingDirectorySettings.model_validate({"url": url})
