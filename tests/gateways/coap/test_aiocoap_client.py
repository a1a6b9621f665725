"""The adapter for aiocoap against servers on loopback: blocks, observations, secured requests, and their ends."""

import json
import time
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing, asynccontextmanager
from pathlib import Path

import aiocoap
import anyio
import pytest
from aiocoap import resource
from aiocoap.credentials import CredentialsMap
from aiocoap.oscore_sitewrapper import OscoreSiteWrapper
from tests.patience import PATIENCE
from tests.ports import reserve_datagram_port
from tests.turns import slowness

from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.coap.aiocoap_client import MAX_BODY, CoapClient
from homebot.gateways.coap.settings import CoapCredentials


class Value(resource.ObservableResource):  # type: ignore[misc]  # the library has no types
    """A value that may be long, and of which the observers may never be told."""

    def __init__(self, payload: bytes, max_age: int | None = None) -> None:
        super().__init__()
        self.payload = payload
        self.max_age = max_age

    async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
        self.authenticated = list(request.remote.authenticated_claims)
        return aiocoap.Message(payload=self.payload, content_format=0, max_age=self.max_age)


@asynccontextmanager
async def server(value: resource.Resource, port: int, credentials: CredentialsMap | None = None) -> AsyncIterator[str]:
    site = resource.Site()
    site.add_resource(["value"], value)
    context = await aiocoap.Context.create_server_context(
        site,
        bind=("127.0.0.1", port),
        transports=["oscore", "udp6"] if credentials else ["udp6"],
        server_credentials=credentials,
    )
    if credentials:
        context.serversite = OscoreSiteWrapper(site, credentials)
    try:
        yield f"coap://127.0.0.1:{port}/value"
    finally:
        await context.shutdown()


async def test_an_address_of_many_brackets_is_refused_in_time_that_grows_with_its_length() -> None:
    """The form of a Thing Description may be as long as that."""
    async with CoapClient.open(5.0, ()) as client:
        began = time.thread_time()
        with pytest.raises((RefusedError, WireError, LinkError)):
            await client.request("GET", f"coap://{'[' * 20_000}/value")
        assert time.thread_time() - began < slowness()


async def test_a_device_is_reached_although_the_network_refuses_others_at_that_moment() -> None:
    """Linux tells the next sender of what is refused, whomever it sends to."""
    async with server(Value(b"21"), reserve_datagram_port()) as uri, CoapClient.open(5.0, ()) as client:
        answers: list[bytes] = []

        async def ask_nobody(port: int) -> None:
            with pytest.raises(
                LinkError,
                match=r"cannot be reached: nothing is listening there \(connection refused\): start it, or",
            ):
                await client.request("GET", f"coap://127.0.0.1:{port}/value")

        async def ask() -> None:
            answers.append((await client.request("GET", uri)).payload)

        for _ in range(5):
            async with anyio.create_task_group() as tasks:
                for _ in range(10):
                    tasks.start_soon(ask_nobody, reserve_datagram_port())
                    tasks.start_soon(ask)
        assert answers == [b"21"] * 50


async def test_a_long_answer_is_put_together_of_its_blocks_up_to_a_limit() -> None:
    value = Value(bytes(range(256)) * 40)
    async with server(value, reserve_datagram_port()) as uri, CoapClient.open(5.0, ()) as client:
        assert (await client.request("GET", uri)).payload == value.payload
        value.payload = b"x" * (MAX_BODY + 1)
        with pytest.raises(WireError, match="is longer than 262144 bytes"):
            await client.request("GET", uri)


async def test_an_answer_of_empty_blocks_without_end_is_refused() -> None:
    class Endless(resource.Resource):  # type: ignore[misc]  # the library has no types
        async def needs_blockwise_assembly(self, request: aiocoap.Message) -> bool:
            del request
            return False

        async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
            asked.append(request)
            number = 0 if request.opt.block2 is None else request.opt.block2.block_number
            return aiocoap.Message(payload=b"", block2=(number, True, 6))

    asked: list[aiocoap.Message] = []
    async with server(Endless(), reserve_datagram_port()) as uri, CoapClient.open(5.0, ()) as client:
        with anyio.fail_after(PATIENCE), pytest.raises(WireError, match="not full and not the last"):
            await client.request("GET", uri)
    assert len(asked) == 1


async def test_missing_and_impossible_resources_are_explained() -> None:
    port = reserve_datagram_port()
    async with server(Value(b"1"), port) as uri, CoapClient.open(5.0, ()) as client:
        with pytest.raises(RefusedError, match=r"4\.04 Not Found"):
            await client.request("GET", f"{uri}/x")
        with pytest.raises(RefusedError, match=r"4\.05 Method Not Allowed"):
            await client.request("PUT", uri, b"2")
        with pytest.raises(RefusedError, match="CoAP has no such method"):
            await client.request("SHOUT", uri)
        with pytest.raises(WireError, match="is not an address"):
            await client.request("GET", "nonsense")
    async with CoapClient.open(1.0, ()) as client:
        with pytest.raises(LinkError, match=r"cannot be reached|does not answer"):
            await client.request("GET", uri)
        with pytest.raises(LinkError, match="cannot be reached"):
            await client.request("GET", "coap://no-such-host.invalid/")


@asynccontextmanager
async def aging(pass_time: Callable[[float], None]) -> AsyncIterator[None]:
    """Let the last state become too old as soon as a newer one is waited for."""

    async def age() -> None:
        await anyio.wait_all_tasks_blocked()
        pass_time(11.5)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(age)
        yield


async def test_an_observation_is_registered_again_when_its_last_state_is_too_old(
    pass_time: Callable[[float], None],
) -> None:
    """A server that was restarted knows of no observation, and tells nobody of its new state."""
    port = reserve_datagram_port()
    async with CoapClient.open(5.0, ()) as client, aclosing(client.observe(f"coap://127.0.0.1:{port}/value")) as states:
        async with server(Value(b"old", max_age=1), port):
            assert (await anext(states)).payload == b"old"
        async with server(Value(b"new", max_age=1), port):
            with anyio.fail_after(PATIENCE):
                async with aging(pass_time):
                    assert (await anext(states)).payload == b"new"


async def test_a_long_state_is_whole_although_its_notification_is_cut_off() -> None:
    """A directory of 57 devices: each later one was found when the list was read, and the others left until then."""
    value = Value(b"short")
    async with (
        server(value, reserve_datagram_port()) as uri,
        CoapClient.open(5.0, ()) as client,
        aclosing(client.observe(uri)) as states,
    ):
        assert (await anext(states)).payload == value.payload
        value.payload = bytes(range(256)) * 17
        value.updated_state()
        assert (await anext(states)).payload == value.payload


async def test_a_server_that_went_away_ends_the_observation_as_a_broken_link(
    pass_time: Callable[[float], None],
) -> None:
    port = reserve_datagram_port()
    async with CoapClient.open(1.0, ()) as client, aclosing(client.observe(f"coap://127.0.0.1:{port}/value")) as states:
        async with server(Value(b"old", max_age=1), port):
            await anext(states)
        async with aging(pass_time):
            with pytest.raises(LinkError):
                await anext(states)


async def test_a_resource_that_cannot_be_observed_is_refused() -> None:
    class Plain(resource.Resource):  # type: ignore[misc]  # the library has no types
        async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
            del request
            return aiocoap.Message(payload=b"1")

    async with server(Plain(), reserve_datagram_port()) as uri, CoapClient.open(5.0, ()) as client:
        with pytest.raises(RefusedError, match="it cannot be observed"):
            await anext(client.observe(uri))


def oscore_context(directory: Path, own: str, other: str) -> str:
    """Write an OSCORE context as aiocoap keeps it; the key is that of RFC 8613, appendix C."""
    directory.mkdir()
    secret = {"secret_hex": "0102030405060708090a0b0c0d0e0f10", "salt_hex": "9e7ca92223786340"}
    settings = {"sender-id_hex": own, "recipient-id_hex": other}
    (directory / "secret.json").write_text(json.dumps(secret), "utf-8")
    (directory / "settings.json").write_text(json.dumps(settings), "utf-8")
    return str(directory)


async def test_a_request_is_secured_by_an_oscore_context(tmp_path: Path) -> None:
    ours, theirs = oscore_context(tmp_path / "ours", "01", "02"), oscore_context(tmp_path / "theirs", "02", "01")
    credentials = CredentialsMap()
    credentials.load_from_dict({":ours": {"oscore": {"basedir": f"{theirs}/"}}})
    value = Value(b"secret")
    async with server(value, reserve_datagram_port(), credentials) as uri:
        async with CoapClient.open(5.0, [CoapCredentials(uri=f"{uri}*", oscore=ours)]) as client:
            assert (await client.request("GET", uri)).payload == b"secret"
            assert value.authenticated == [":ours"]
        async with CoapClient.open(5.0, ()) as client:
            await client.request("GET", uri)
            assert value.authenticated == []
