"""Devices that leave while they are told something, and strangers that send what they like."""

from __future__ import annotations

import random
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import aiocoap
import anyio
import pytest
from aiocoap import resource
from structlog.testing import capture_logs
from tests.gateways.coap.test_gateway import device, post
from tests.gateways.coap.watched import watched_gateway
from tests.patience import PATIENCE
from tests.ports import reserve_datagram_port
from tests.sizes import size

from homebot.clock import ManualClock
from homebot.conventions.coap.registry import MAX_PER_HOST
from homebot.devices.health import Count
from homebot.gateways.coap.aiocoap_client import CoapClient, GroupAnswer
from homebot.gateways.coap.gateway import MAX_PER_HOST as MAX_PER_ADDRESS
from homebot.house.coap_devices import CoapDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

FLOOD = size(2_000, 10_000)


class _LeavingResource(resource.Resource):  # type: ignore[misc] # the library has no types
    """Takes the power away from its device instead of answering."""

    def __init__(self, lamp: LeavingLamp) -> None:
        super().__init__()
        self._lamp = lamp

    async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
        del request
        return aiocoap.Message(payload=b"false", content_format=50)

    async def render_put(self, request: aiocoap.Message) -> aiocoap.Message:
        del request
        self._lamp.power(on=False)
        return await anyio.sleep_forever()


class LeavingLamp(CoapDevice):
    """A lamp whose power fails with the first command."""

    def _make_resources(self) -> list[tuple[tuple[str, ...], resource.Resource]]:
        return [(path, _LeavingResource(self) if path == ("on",) else one) for path, one in super()._make_resources()]


async def test_a_lamp_that_leaves_while_it_is_told_is_unreachable_and_the_others_obey() -> None:
    info = SimulatedDeviceInfo("house", "lamp", "Leaving", "lights", "hall")
    leaving = LeavingLamp(info, lambda _command: None)
    leaving.begin(DeviceState(text="off"), has_power=True)
    async with anyio.create_task_group() as tasks, device() as lamp:
        tasks.start_soon(leaving.live)
        async with watched_gateway(devices=[leaving.uri, lamp.uri]) as watcher:
            keys = {leaving.uri, lamp.uri}
            while keys:
                keys.discard((await watcher.sighting(lambda one: bool(one.parts))).key)
            response = await watcher.tell(leaving.uri, "on_off", True)
            assert (response.success, response.problem) == (False, "unreachable")
            assert (await watcher.tell(lamp.uri, "on_off", True)).success
            assert set(watcher.gateway.devices.keys) == {leaving.uri, lamp.uri}
        tasks.cancel_scope.cancel()


async def test_a_flood_of_fake_registrations_take_no_more_room_than_is_allowed() -> None:
    port = reserve_datagram_port()
    async with device() as lamp, watched_gateway(serve_directory=f"127.0.0.1:{port}", devices=[lamp.uri]) as watcher:
        await watcher.sighting(lambda one: bool(one.parts))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.setblocking(False)
            for number in range(FLOOD):
                stranger.sendto(registration(number), ("127.0.0.1", port))
                if number % 20 == 0:
                    await anyio.sleep(0.001)
        answer = await post(f"coap://127.0.0.1:{port}/rd-lookup/ep", b"", aiocoap.GET)  # after all of them
        assert answer.code.is_successful()
        assert 1 < len(watcher.gateway.devices.keys) <= MAX_PER_HOST + 1
        assert (await watcher.tell(lamp.uri, "on_off", True)).success
        await watcher.reported("on_off", True)


async def test_datagrams_that_are_no_coap_change_nothing() -> None:
    port, rng = reserve_datagram_port(), random.Random(1)  # noqa: S311 - noise
    async with watched_gateway(serve_directory=f"127.0.0.1:{port}") as watcher:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.setblocking(False)
            for number in range(2000):
                stranger.sendto(rng.randbytes(rng.randrange(1, 60)), ("127.0.0.1", port))
                if number % 20 == 0:
                    await anyio.sleep(0.001)
        answer = await post(f"coap://127.0.0.1:{port}/rd?ep=real&base=coap://127.0.0.2:9", b"</on>;rt=light")
        assert answer.code.dotted == "2.01"
        assert (await watcher.sighting(lambda one: "real" in one.name)).kind == "appeared"


async def test_requests_beyond_the_limit_are_dropped() -> None:
    """The library remembers each for four minutes."""
    port = reserve_datagram_port()
    async with watched_gateway(ManualClock(), serve_directory=f"127.0.0.1:{port}") as watcher:
        with stranger(port) as client, anyio.fail_after(PATIENCE):
            for number in range(1000):
                assert await answer(client, aiocoap.Message(code=aiocoap.GET), number)
            for number in range(1000, 1003):
                client.send(b"\x40\x01" + number.to_bytes(2))
            while Count(name="requests_dropped", count=3) not in (await watcher.health()).counts:  # noqa: ASYNC110 - no event
                await anyio.sleep(0.01)
            with pytest.raises(BlockingIOError):
                client.recv(1500)


async def test_the_socket_that_asks_answers_no_requests() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as lamp:
        lamp.bind(("127.0.0.1", 0))
        lamp.setblocking(False)
        async with CoapClient.open(PATIENCE, ()) as client, anyio.create_task_group() as tasks:
            tasks.start_soon(client.request, "GET", f"coap://127.0.0.1:{lamp.getsockname()[1]}/x")
            await anyio.wait_readable(lamp)
            question, asker = lamp.recvfrom(1000)
            for number in range(3):
                lamp.sendto(b"\x40\x01" + number.to_bytes(2) + b"\xb1x", asker)
            token = question[4 : 4 + (question[0] & 15)]
            lamp.sendto(bytes([0x60 | len(token), 0x45]) + question[2:4] + token, asker)  # the answer
        with pytest.raises(BlockingIOError):
            lamp.recv(1000)


async def test_parts_of_a_registration_out_of_order_or_without_end_are_refused() -> None:
    port, codes = reserve_datagram_port(), []
    with capture_logs() as logs:
        async with watched_gateway(serve_directory=f"127.0.0.1:{port}"):
            with stranger(port) as client:
                for mid, number in enumerate((*range(64), 64, 70, 2)):
                    message = aiocoap.Message(code=aiocoap.POST, uri="coap://here/rd?ep=long", payload=b"x" * 1024)
                    message.opt.block1 = (number, True, 6)
                    codes.append(await answer(client, message, mid))
    assert codes == ["2.31"] * 64 + ["4.13", "4.13", "4.08"]
    assert not [one for one in logs if one["log_level"] == "error"]


async def test_a_host_that_answers_from_many_ports_keeps_no_other_out() -> None:
    """Nor one whose address begins alike."""
    async with watched_gateway(serve_directory=f"127.0.0.1:{reserve_datagram_port()}", timeout=PATIENCE) as watcher:
        for port in range(1, 60):
            watcher.gateway._answered(GroupAnswer("127.0.0.12", port, b"</on>", is_whole=True))
        assert len(watcher.gateway._sessions) == MAX_PER_ADDRESS
        watcher.gateway._answered(GroupAnswer("127.0.0.1", 5683, b"</on>", is_whole=True))
        assert len(watcher.gateway._sessions) == MAX_PER_ADDRESS + 1


async def test_a_host_that_answers_from_many_ports_and_is_silent_delays_no_other() -> None:
    async with device() as lamp, watched_gateway(devices=["coap://127.0.0.2"], timeout=300.0) as watcher:
        with ExitStack() as silent:
            for _ in range(MAX_PER_ADDRESS):
                opened = silent.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                opened.bind(("127.0.0.12", 0))
                watcher.gateway._answered(GroupAnswer("127.0.0.12", opened.getsockname()[1], b"</on>", is_whole=True))
            port = int(lamp.uri.rpartition(":")[2])
            watcher.gateway._answered(GroupAnswer("127.0.0.1", port, b"</on>", is_whole=True))
            assert (await watcher.sighting(lambda one: bool(one.parts))).key == lamp.uri


@contextmanager
def stranger(port: int) -> Iterator[socket.socket]:
    """Connect a socket of a host that knows CoAP to *port*."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.connect(("127.0.0.1", port))
        opened.setblocking(False)
        yield opened


async def answer(client: socket.socket, message: aiocoap.Message, number: int) -> str:
    """Send *message* under a number of its own; return the code of the answer, empty if none comes soon."""
    message.mtype, message.mid, message.token = aiocoap.CON, number, number.to_bytes(2)
    client.send(message.encode())
    with anyio.move_on_after(PATIENCE):
        await anyio.wait_readable(client)
        return str(aiocoap.Message.decode(client.recv(1500)).code.dotted)
    return ""


def registration(number: int) -> bytes:
    """A registration that wants no acknowledgement, as RFC 7252 encodes it."""
    head = b"\x54\x02" + (number % 65_536).to_bytes(2) + number.to_bytes(4)
    endpoint, base = f"ep=fake{number}".encode(), f"base=coap://127.0.0.2:{number + 1}".encode()
    path, content_format = b"\xb2rd", b"\x11\x28"
    return head + path + content_format + _query(3, endpoint) + _query(0, base)


def _query(delta: int, text: bytes) -> bytes:
    short = len(text) < 13
    return bytes([delta << 4 | (len(text) if short else 13)]) + (b"" if short else bytes([len(text) - 13])) + text
