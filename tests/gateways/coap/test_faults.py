"""Devices that leave while they are told something, and strangers that send what they like."""

from __future__ import annotations

import socket
from contextlib import ExitStack

import aiocoap
import anyio
import pytest
from aiocoap import resource
from tests.gateways.coap.test_gateway import device
from tests.gateways.coap.watched import watched_gateway
from tests.patience import PATIENCE
from tests.simulated.coap_devices import CoapDevice
from tests.sizes import size

from homebot.gateways.coap.aiocoap_client import CoapClient, GroupAnswer
from homebot.gateways.coap.gateway import MAX_PER_HOST as MAX_PER_ADDRESS
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


@pytest.mark.rooms("things")
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


@pytest.mark.rooms("things")
async def test_a_host_that_answers_from_many_ports_keeps_no_other_out() -> None:
    """Nor one whose address begins alike."""
    async with watched_gateway(devices=["coap://127.0.0.2"], timeout=PATIENCE) as watcher:
        for port in range(1, 60):
            watcher.gateway._on_answer(GroupAnswer("127.0.0.12", port, b"</on>", is_whole=True))
        assert len(watcher.gateway._sessions) == 1 + MAX_PER_ADDRESS
        watcher.gateway._on_answer(GroupAnswer("127.0.0.1", 5683, b"</on>", is_whole=True))
        assert len(watcher.gateway._sessions) == 2 + MAX_PER_ADDRESS


@pytest.mark.rooms("things")
async def test_a_host_that_answers_from_many_ports_and_is_silent_delays_no_other() -> None:
    async with device() as lamp, watched_gateway(devices=["coap://127.0.0.2"], timeout=300.0) as watcher:
        with ExitStack() as silent:
            for _ in range(MAX_PER_ADDRESS):
                opened = silent.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
                opened.bind(("127.0.0.12", 0))
                watcher.gateway._on_answer(GroupAnswer("127.0.0.12", opened.getsockname()[1], b"</on>", is_whole=True))
            port = int(lamp.uri.rpartition(":")[2])
            watcher.gateway._on_answer(GroupAnswer("127.0.0.1", port, b"</on>", is_whole=True))
            assert (await watcher.sighting(lambda one: bool(one.parts))).key == lamp.uri


def _query(delta: int, text: bytes) -> bytes:
    short = len(text) < 13
    return bytes([delta << 4 | (len(text) if short else 13)]) + (b"" if short else bytes([len(text) - 13])) + text
