"""Devices that leave while they are told something, and strangers that send what they like."""

from __future__ import annotations

import random
import socket

import aiocoap
import anyio
from aiocoap import resource
from tests.gateways.coap.test_gateway import device, post
from tests.gateways.coap.watched import watched_gateway
from tests.ports import reserve_datagram_port
from tests.sizes import size

from homebot.conventions.coap.registry import MAX_PER_HOST
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


def registration(number: int) -> bytes:
    """A registration that wants no acknowledgement, as RFC 7252 encodes it."""
    head = b"\x54\x02" + (number % 65_536).to_bytes(2) + number.to_bytes(4)
    endpoint, base = f"ep=fake{number}".encode(), f"base=coap://127.0.0.2:{number + 1}".encode()
    path, content_format = b"\xb2rd", b"\x11\x28"
    return head + path + content_format + _query(3, endpoint) + _query(0, base)


def _query(delta: int, text: bytes) -> bytes:
    short = len(text) < 13
    return bytes([delta << 4 | (len(text) if short else 13)]) + (b"" if short else bytes([len(text) - 13])) + text
