"""The gateway of tags with pcscd, the smart-card service of Linux, and its virtual reader vpcd with a simulated tag.

vpcd (vsmartcard) listens for cards on TCP: each message has two bytes of length; one byte is a control: 0 power off,
1 power on, 2 reset, 4 the answer to reset is asked for; all else are APDUs.
"""

import importlib.util
import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from threading import Thread

import anyio
import pytest
from tests.gateways.nfc.test_gateway import HOUSE, LAMP
from tests.gateways.nfc.world import KEPT, UID, card, uri
from tests.patience import PATIENCE
from tests.peers.network import Machine
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.ndef_message import read_ndef
from homebot.devices import FIND_DEVICES, FindDevices, GatewayState
from homebot.devices.gateway_messages import Report
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.devices.tags import ReadTag, ReadTagRequest, TagTap, WriteTag, WriteTagRequest
from homebot.gateways.nfc import NfcGateway, NfcGatewaySettings
from homebot.graph import Graph, Node

PORT = 35963
DEBIAN_PYSCARD = Path("/usr/lib/python3/dist-packages/smartcard")
ANSWER_TO_RESET = bytes.fromhex("3B8180018080")


def why_no_service() -> str:
    if shutil.which("pcscd") is None or not Path("/etc/reader.conf.d/vpcd").exists():
        return "pcscd with a virtual reader is not installed: apt install pcscd vsmartcard-vpcd"
    if os.getuid() != 0:
        return "pcscd must be run by root"
    return ""


pytestmark = pytest.mark.skipif(bool(why_no_service()), reason=why_no_service())


@pytest.fixture(scope="module", autouse=True)
def _pyscard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """pyscard, which has no wheel for Linux: that of Debian where it fits this Python, else one that was built here."""
    if importlib.util.find_spec("smartcard") is not None:
        yield
        return
    if not list(DEBIAN_PYSCARD.glob(f"scard/_scard.{sys.implementation.cache_tag}-*.so")):
        pytest.skip("pyscard is not installed: apt install python3-pyscard, where Debian's Python is of this version")
    place = tmp_path_factory.mktemp("pyscard")
    (place / "smartcard").symlink_to(DEBIAN_PYSCARD)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(place)
        yield


class Service:
    """pcscd, by hand, on a machine of its own: any socket may have got the port of its virtual reader."""

    def __init__(self, machine: Machine) -> None:
        self._command = machine.command("pcscd", "-f")
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        Path("/run/pcscd").mkdir(exist_ok=True)
        self._process = subprocess.Popen(self._command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def stop(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGTERM)
            self._process.wait(10)
        self._process = None


@pytest.fixture
def service(hub: Machine) -> Iterator[Service]:
    service = Service(hub)
    try:
        yield service
    finally:
        service.stop()


@contextmanager
def inserted(tag: Type4Card) -> Iterator[None]:
    """Have *tag* in the virtual reader inside the block."""
    with socket.create_connection(("127.0.0.1", PORT), 5) as connection:
        thread = Thread(target=_answer, args=(connection, tag), daemon=True)
        thread.start()
        try:
            yield
        finally:
            connection.shutdown(socket.SHUT_RDWR)
            thread.join()


def _answer(connection: socket.socket, tag: Type4Card) -> None:
    connection.settimeout(None)
    with suppress(ConnectionError), connection.makefile("rb") as stream:  # taken out while it answers
        while len(size := stream.read(2)) == 2:
            message = stream.read(int.from_bytes(size, "big"))
            if message in {b"\x00", b"\x01", b"\x02"}:
                continue
            answer = ANSWER_TO_RESET if message == b"\x04" else tag.answer(message)
            connection.sendall(len(answer).to_bytes(2, "big") + answer)


def _has_left(report: Report) -> bool:
    return any(one.capability == "connectivity" and one.value.plain() is False for one in report.readings)


@asynccontextmanager
async def gateway() -> AsyncIterator[Node]:
    graph = Graph()
    async with Node(graph, "watcher") as watcher, Node(graph, "nfc", namespace="/gateway") as node:

        def answer(request: FindDevicesRequest) -> FindDevicesResponse:
            del request
            return FindDevicesResponse(devices=HOUSE, sequence=0)

        watcher.create_service(FindDevices, FIND_DEVICES, answer)
        async with anyio.create_task_group() as tasks:
            await tasks.start(NfcGateway(node, NfcGatewaySettings(backend="pcsc")).serve)
            yield watcher
            tasks.cancel_scope.cancel()


@pytest.mark.newest("nfc")
async def test_a_tag_at_a_reader_of_the_smart_card_service_is_read_and_written(service: Service) -> None:
    service.start()
    async with gateway() as watcher:
        states = watcher.create_subscription(GatewayState, "/gateway/nfc/state", qos_profile=KEPT)
        reports = watcher.create_subscription(Report, "/gateway/nfc/readings", qos_profile=100)
        taps = watcher.create_subscription(TagTap, "/gateway/nfc/taps", qos_profile=10)
        with anyio.fail_after(PATIENCE):
            while (await states.receive()).state != "active":
                pass
            tag = card(uri("homebot:device/lights/hall"))
            with inserted(tag):
                tap = await taps.receive()
                assert (tap.tag, tap.device) == (UID, "lights/hall")
                assert "Virtual PCD" in tap.reader
                write = watcher.create_client(WriteTag, "/gateway/nfc/write_tag")
                written = await write.call(WriteTagRequest(device="Kitchen lamp", wait=PATIENCE), timeout=PATIENCE)
                assert (written.success, written.message, written.tag) == (True, "", UID)
                assert read_ndef(tag.message)[0].data == b"homebot:device/lights/kitchen"
                read = watcher.create_client(ReadTag, "/gateway/nfc/read_tag")
                assert (await read.call(ReadTagRequest(wait=PATIENCE), timeout=PATIENCE)).device == LAMP.id
            while not _has_left(await reports.receive()):
                pass
            assert (await read.call(ReadTagRequest(wait=0.1), timeout=PATIENCE)).problem == "no_tag"


async def test_a_service_that_stops_and_starts_again_is_a_state_with_a_reason(service: Service) -> None:
    async with gateway() as watcher:
        states = watcher.create_subscription(GatewayState, "/gateway/nfc/state", qos_profile=KEPT)
        with anyio.fail_after(PATIENCE):
            absent = await states.receive()
            assert absent.state == "unavailable"
            assert "pcscd" in absent.reason
            for _ in range(2):
                service.start()
                while (await states.receive()).state != "active":
                    pass
                await anyio.to_thread.run_sync(service.stop)
                while (await states.receive()).state != "unavailable":
                    pass
