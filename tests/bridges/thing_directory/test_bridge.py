"""homebot's directory over HTTP: the list, descriptions, values, commands, events, and who is let in."""

import json
import tomllib
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import quote

import aiohttp
import anyio
import pytest
from tests.bridges.thing_directory.conftest import LAMP, OWNER, OpenHouse, ServedHouse
from tests.patience import PATIENCE
from yarl import URL

from homebot.bridges.thing_directory.bridge import ThingDirectoryBridge
from homebot.bridges.thing_directory.settings import DirectoryBridgeSettings
from homebot.config import parse_config
from homebot.control import Control, ControlSettings
from homebot.devices.health import HealthRequest
from homebot.errors import ConfigError, UsageError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.graph import Graph, Node
from homebot.runtime.plan import make_plan
from homebot.wot.parse import read_thing


async def lamp_of(house: ServedHouse) -> tuple[dict[str, Any], str]:
    """Return the description of the lamp, and its path."""
    found = next(one for one in await house.things(2) if one["title"] == "Hall lamp")
    return found, f"/things/{quote(found['id'], safe='')}"


async def next_event(answer: aiohttp.ClientResponse) -> dict[str, str]:
    """Return the next event of a stream."""
    fields: dict[str, str] = {}
    with anyio.fail_after(PATIENCE):
        while True:
            line = (await answer.content.readline()).decode().rstrip("\n")
            if not line and "data" in fields:
                return fields
            name, _, value = line.partition(": ")
            if name:
                fields[name] = value


async def test_each_device_is_listed_as_a_thing_that_homebot_itself_can_read(served_house: OpenHouse) -> None:
    async with served_house() as house:
        listed = await house.things(2)
        assert [one["id"] for one in listed] == sorted(one["id"] for one in listed)
        lamp, path = await lamp_of(house)
        status, retrieved = await house.get(path)
        assert (status, retrieved) == (200, lamp)
    thing = read_thing(lamp)
    assert (thing.title, thing.area, thing.identifiers) == ("Hall lamp", "Hall", ("mac:aabbccddeeff",))
    forms = {one.name: one.forms[0] for one in thing.affordances}
    assert set(forms) == {"on_off", "level"}
    assert forms["level"].href.startswith(house.url)
    assert forms["level"].ops == ("readproperty", "writeproperty")


async def test_values_are_read_and_set_at_the_addresses_of_the_description(house: ServedHouse) -> None:
    lamp, path = await lamp_of(house)
    assert await house.get(f"{path}/properties") == (200, {"on_off": True, "level": 40.0})
    href = lamp["properties"]["level"]["forms"][0]["href"]
    assert await house.put(href, b"70") == (204, None)
    assert [(one.capability, one.value.plain()) for one in house.gateway.commands] == [("level", 70.0)]
    with anyio.fail_after(PATIENCE):
        while await house.get(href) != (200, 70.0):  # noqa: ASYNC110 - it is another program's
            await anyio.sleep(0.02)


async def test_a_client_that_waits_until_it_may_send_the_body_is_told_so(house: ServedHouse) -> None:
    """As .NET Framework does for each PUT, and curl for large ones."""
    lamp, _ = await lamp_of(house)
    href = lamp["properties"]["level"]["forms"][0]["href"]
    head = f"PUT {href} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 2\r\nExpect: 100-continue\r\n\r\n"
    async with await anyio.connect_tcp("127.0.0.1", house.bridge.port) as stream:
        with anyio.fail_after(PATIENCE):
            await stream.send(head.encode())
            assert await stream.receive() == b"HTTP/1.1 100 Continue\r\n\r\n"
            await stream.send(b"70")
            assert (await stream.receive()).startswith(b"HTTP/1.1 204 ")


@pytest.mark.parametrize(
    ("name", "body", "status"),
    [
        ("level", b"700", 400),
        ("level", b'"x"', 400),
        ("level", b"true", 400),
        ("level", b"1e999", 400),
        ("level", b"1" * 400, 400),
        ("level", b" " * 70_000, 413),
        ("on_off", b"1", 400),
        ("nothing", b"1", 404),
    ],
)
async def test_an_invalid_value_is_refused_with_a_reason(
    house: ServedHouse, name: str, body: bytes, status: int
) -> None:
    _, path = await lamp_of(house)
    found, problem = await house.put(f"{path}/properties/{name}", body)
    assert (found, problem["status"]) == (status, status)
    assert problem["detail"]
    assert not house.gateway.commands


@pytest.mark.parametrize(
    ("name", "body", "said"),
    [
        ("level", b"", "the body is empty; the value of level is a number"),
        ("level", b" \n", "the body is empty; the value of level is a number"),
        ("level", b"{", "the body is not valid JSON; the value of level is a number"),
        ("on_off", b"on", "the body is not valid JSON; the value of on_off is true or false"),
        ("on_off", b"\xff", "the body is not valid JSON; the value of on_off is true or false"),
    ],
)
async def test_a_body_without_a_value_is_refused_with_the_expected_one(
    house: ServedHouse, name: str, body: bytes, said: str
) -> None:
    _, path = await lamp_of(house)
    assert (await house.put(f"{path}/properties/{name}", body))[1]["detail"] == said


async def test_a_read_only_property_is_not_set(served_house: OpenHouse) -> None:
    async with served_house(allows_commands=False) as house:
        lamp, path = await lamp_of(house)
        assert lamp["properties"]["on_off"]["forms"][0]["op"] == ["readproperty"]
        assert (await house.put(f"{path}/properties/on_off", b"true"))[0] == 405
    async with served_house() as house:
        sensor = quote(next(one["id"] for one in await house.things(2) if one["title"] == "Attic"), safe="")
        assert (await house.put(f"/things/{sensor}/properties/temperature", b"5"))[0] == 405
        house.gateway.set_unavailable("no radio")
        _, path = await lamp_of(house)
        status, problem = await house.put(f"{path}/properties/on_off", b"true")
        assert status == 503
        assert "no radio" in problem["detail"]


@asynccontextmanager
async def controlled(house: ServedHouse, grants: Mapping[str, tuple[str, ...]]) -> AsyncIterator[None]:
    """Run a control layer that trusts no app, and knows these *grants*, inside the block."""
    async with Node(house.gateway.node.graph, "control") as node, anyio.create_task_group() as tasks:
        await tasks.start(Control(node, ControlSettings(approvals=False), grants, trusts_apps=False).serve)
        yield
        tasks.cancel_scope.cancel()


async def test_a_lock_is_not_unlocked_until_the_owner_allows_it(house: ServedHouse) -> None:
    """The refusal says how: the line of the table, which works as it stands after a restart."""
    house.gateway.devices.put(
        GatewayDevice("door", "Front door", (simple_part("door_lock", settable=("lock",)),)), "new"
    )
    lock = next(one["id"] for one in await house.things(3) if one["title"] == "Front door")
    where = f"/things/{quote(lock, safe='')}/properties/lock"
    async with controlled(house, {}):
        status, problem = await house.put(where, b'"unlocked"')
    assert status == 403
    line = problem["detail"].partition("; ")[2].removesuffix(" gives one")
    assert line.startswith("[thing_directory] act = [")
    config = parse_config(tomllib.loads(line.replace("] act", "]\nact")), "homebot.toml")
    assert not house.gateway.commands
    async with controlled(house, make_plan(config).grants):
        assert await house.put(where, b'"unlocked"') == (204, None)
    assert [one.value.plain() for one in house.gateway.commands] == ["unlocked"]


async def test_the_list_is_read_only(house: ServedHouse) -> None:
    _, path = await lamp_of(house)
    for method, where in (("POST", "/things"), ("PUT", path), ("PATCH", path), ("DELETE", path)):
        async with house.client.request(method, f"{house.url}{where}", data=b"{}") as answer:
            assert answer.status == 405
            assert answer.headers["Allow"] == "GET, HEAD"
            assert answer.content_type == "application/problem+json"
            assert (await answer.json(content_type=None))["title"] == "Method Not Allowed"


async def test_the_list_comes_in_pages_that_name_the_next(house: ServedHouse) -> None:
    for number in range(6):
        house.gateway.devices.put(GatewayDevice(f"plug {number}", f"Plug {number}", LAMP.parts), "new")
    everything = [one["id"] for one in await house.things(8)]
    found, where = [], "/things?limit=3"
    while where:
        async with house.client.get(f"{house.url}{where}") as answer:
            page = [one["id"] for one in await answer.json(content_type=None)]
            assert 0 < len(page) <= 3
            found += page
            where = URL(str(answer.links["next"]["url"])).path_qs if "next" in answer.links else ""
    assert found == everything
    backwards = (await house.get("/things?sort_by=id&sort_order=desc"))[1]
    assert [one["id"] for one in backwards] == everything[::-1]
    collection = (await house.get("/things?limit=5&format=collection"))[1]
    assert (collection["total"], len(collection["members"])) == (8, 5)
    assert len((await house.get(collection["next"]))[1]["members"]) == 3


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/", 404),
        ("/things/urn:none", 404),
        ("/things/urn:none/properties", 404),
        ("/things?limit=0", 400),
        ("/things?limit=x", 400),
        ("/things?offset=-1", 400),
        ("/things?offset=1e9", 400),
        ("/things?sort_by=title", 501),
        ("/things?sort_order=up", 400),
        ("/things?format=xml", 400),
        ("/search/jsonpath?query=$", 404),
        ("/events/thing_stolen", 404),
        ("/events/thing_created/x", 404),
        ("/%2e%2e/%2e%2e/etc/passwd", 404),
        ("/a/b/c/d/e/f/g/h/i/j/k", 404),
    ],
)
async def test_an_unknown_thing_is_answered_with_a_problem(house: ServedHouse, path: str, status: int) -> None:
    found, problem = await house.get(path)
    assert (found, problem["status"]) == (status, status)


async def test_a_client_that_has_the_newest_gets_no_body(house: ServedHouse) -> None:
    _, path = await lamp_of(house)
    etag = ""
    for where in ("/things", path):
        async with house.client.get(f"{house.url}{where}") as answer:
            etag = answer.headers["ETag"]
        assert await house.get(where, **{"If-None-Match": f'"other", W/{etag}'}) == (304, None)
        assert (await house.get(where, **{"If-None-Match": '"other"'}))[0] == 200
    async with house.client.head(f"{house.url}{path}") as answer:
        assert (answer.status, answer.headers["ETag"], await answer.read()) == (200, etag, b"")


async def test_changes_are_told_as_events_and_again_from_where_a_client_left(house: ServedHouse) -> None:
    await house.things(2)
    async with house.client.get(f"{house.url}/events?diff=true") as answer:
        assert answer.content_type == "text/event-stream"
        house.gateway.devices.put(GatewayDevice("desk", "Desk", LAMP.parts), "new")
        created = await next_event(answer)
        assert created["event"] == "thing_created"
        described = json.loads(created["data"])
        assert (described["title"], described["base"]) == ("Desk", f"{house.url}/")
        house.gateway.devices.put(GatewayDevice("desk", "My desk", LAMP.parts), "renamed")
        updated = await next_event(answer)
        while "title" not in updated["data"]:
            updated = await next_event(answer)
        assert updated["event"] == "thing_updated"
        assert json.loads(updated["data"])["title"] == "My desk"
        assert "properties" not in json.loads(updated["data"])
    house.gateway.devices.remove("desk", "gone")
    headers = {"Last-Event-ID": updated["id"]}
    async with house.client.get(f"{house.url}/events", headers=headers) as answer:
        deleted = await next_event(answer)
    assert deleted["event"] == "thing_deleted"
    assert json.loads(deleted["data"]) == {"id": described["id"]}


async def test_one_kind_of_event_can_be_asked_for(house: ServedHouse) -> None:
    await house.things(2)
    async with house.client.get(f"{house.url}/events/thing_deleted") as answer:
        house.gateway.devices.put(GatewayDevice("desk", "Desk", LAMP.parts), "new")
        await house.things(3)
        house.gateway.devices.remove("desk", "gone")
        event = await next_event(answer)
    assert event["event"] == "thing_deleted"


async def test_a_client_without_the_token_is_rejected(served_house: OpenHouse) -> None:
    async with served_house(token="sesame") as house:
        for headers in ({}, {"Authorization": "Bearer wrong"}):
            async with house.client.get(f"{house.url}/things", headers=headers) as answer:
                assert answer.status == 401
                assert answer.headers["WWW-Authenticate"] == "Bearer"
        assert (await house.get("/things?token=sesame"))[0] == 401  # an address stays in histories and logs
        status, listed = await house.get("/things", Authorization="Bearer sesame")
        assert status == 200
        assert all(one["security"] == "bearer_sc" for one in listed)
        assert "sesame" not in json.dumps(listed)
        for _ in range(8):
            assert (await house.get("/things"))[0] in {401, 429}
        health = house.bridge.health(HealthRequest())
        assert any("127.0.0.1" in one for one in health.troubles)


async def test_an_address_for_others_needs_a_token() -> None:
    settings = DirectoryBridgeSettings(host="0.0.0.0")  # noqa: S104 - the case under test
    with pytest.raises(ConfigError, match="needs a token"):
        ThingDirectoryBridge(Node(Graph(), "thing_directory"), settings, "villa", OWNER)


async def test_a_port_that_is_taken_is_named(house: ServedHouse) -> None:
    node = Node(Graph(), "thing_directory")
    other = ThingDirectoryBridge(node, DirectoryBridgeSettings(port=house.bridge.port), "villa", OWNER)
    with pytest.raises(UsageError, match=rf"thing_directory: 127.0.0.1:{house.bridge.port} is in use"):
        await other.run()


async def test_it_is_announced_while_it_runs(served_house: OpenHouse) -> None:
    async with served_house() as house:
        service = house.announced[-1]
        facts = {one.key: one.value for one in service.facts}
        assert (service.service_type, service.port) == ("_wot._tcp", house.bridge.port)
        assert facts == {"td": "/.well-known/wot", "type": "Directory"}
        _, own = await house.get(facts["td"])
        assert own["@type"] == "ThingDirectory"
        assert read_thing(own).types == ("ThingDirectory",)
    assert house.announced[-1].is_withdrawn


async def test_devices_of_another_homebots_directory_are_not_listed_again(house: ServedHouse) -> None:
    """Two that follow each other would describe them back and forth, as new devices each time."""
    key = "urn:homebot:0123456789abcdef:lamp"
    house.gateway.devices.put(GatewayDevice(key, "Theirs", LAMP.parts[:1]), "new")
    house.gateway.devices.put(GatewayDevice("desk", "Desk", (simple_part("switch", settable=("on_off",)),)), "new")
    assert "Theirs" not in {one["title"] for one in await house.things(3)}
