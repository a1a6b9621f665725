"""Readers that are not there, and readers that say too much."""

import anyio
import pytest
from tests.gateways.nfc.world import KEPT, UID, take, uri
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.config import parse_settings
from homebot.conventions.nfc.ndef_message import TagContent
from homebot.devices import GatewayState
from homebot.devices.tags import TagTap
from homebot.errors import ConfigError, LinkError
from homebot.gateways import GatewayContext
from homebot.gateways.nfc import NfcGateway, NfcGatewaySettings
from homebot.gateways.nfc.reader import ReaderDesk, TagReader, TagReaders
from homebot.graph import Graph, Node


class PaperTag:
    """A tag that says *message*."""

    tag_type = "paper"

    def __init__(self, uid: str, message: bytes) -> None:
        self.uid = uid
        self._message = message

    def read(self) -> TagContent:
        return TagContent(self._message, 100, is_writable=False)

    def write(self, message: bytes) -> None:
        raise NotImplementedError


class FloodReader(TagReader):
    """A reader that a known tag is held to, then many others that never leave, then the known one again."""

    def run(self, desk: ReaderDesk) -> None:
        desk.found("flood")
        desk.arrived("flood", PaperTag(UID, uri("homebot:device/first")))
        desk.wait(0.2)
        for number in range(size(1_000, 10_000)):
            desk.arrived("flood", PaperTag(f"05{number:012x}", uri(f"http://10.0.0.1/{number}")))
        desk.arrived("flood", PaperTag("ff" * 7, b""))
        while not desk.wait(0.05):
            desk.arrived("flood", PaperTag(UID, uri("homebot:device/again")))


class BrokenReader(TagReader):
    """A reader that fails three times."""

    def __init__(self) -> None:
        self.tries = 0

    def run(self, desk: ReaderDesk) -> None:
        self.tries += 1
        if self.tries < 3:
            raise LinkError(f"attempt {self.tries} failed")
        desk.found("mended")
        while not desk.wait(0.05):
            pass


async def test_a_flood_of_tags_is_bounded_and_the_others_are_read() -> None:
    graph = Graph()
    async with Node(graph, "watcher") as watcher, Node(graph, "nfc", namespace="/gateway") as node:
        taps = watcher.create_subscription(TagTap, "/gateway/nfc/taps", qos_profile=10_000)
        gateway = NfcGateway(node, NfcGatewaySettings(max_tags=100), GatewayContext.of(TagReaders((FloodReader(),))))
        async with anyio.create_task_group() as tasks:
            await tasks.start(gateway.serve)
            with anyio.fail_after(PATIENCE):
                while (await taps.receive()).points_to != "again":
                    pass
            assert UID in gateway.devices.keys
            assert len(gateway.devices.keys) <= 200
            assert len(gateway.at_reader) <= 64
            counters = gateway.devices.counters
            assert counters.rejected + counters.devices_refused > 0
            tasks.cancel_scope.cancel()


async def test_a_reader_that_fails_is_tried_again() -> None:
    graph, reader = Graph(), BrokenReader()
    async with Node(graph, "watcher") as watcher, Node(graph, "nfc", namespace="/gateway") as node:
        states = watcher.create_subscription(GatewayState, "/gateway/nfc/state", qos_profile=KEPT)
        gateway = NfcGateway(node, context=GatewayContext.of(TagReaders((reader,))))
        async with anyio.create_task_group() as tasks:
            await tasks.start(gateway.serve)
            first = await take(states)
            assert (first.state, first.reason) == ("unavailable", "attempt 1 failed")
            with anyio.fail_after(PATIENCE):
                while (await states.receive()).state != "active":
                    pass
            assert reader.tries == 3
            tasks.cancel_scope.cancel()


async def test_a_reader_of_nfcpy_that_is_not_there_is_a_reason() -> None:
    graph = Graph()
    async with Node(graph, "watcher") as watcher, Node(graph, "nfc", namespace="/gateway") as node:
        states = watcher.create_subscription(GatewayState, "/gateway/nfc/state", qos_profile=KEPT)
        settings = NfcGatewaySettings(devices=("tty:HOMEBOT9:pn532",))
        async with anyio.create_task_group() as tasks:
            await tasks.start(NfcGateway(node, settings).serve)
            state = await take(states)
            assert state.state == "unavailable"
            assert "tty:HOMEBOT9:pn532" in state.reason
            tasks.cancel_scope.cancel()


@pytest.mark.parametrize(
    ("key", "value", "became"),
    [("backend", "pcsc", "nfcpy reads tags at all readers"), ("readers", ["ACR122"], "name the readers in devices")],
)
def test_a_key_that_is_gone_is_a_mistake_that_says_what_became_of_it(key: str, value: object, became: str) -> None:
    with pytest.raises(ConfigError, match=rf"gateways\.nfc\.{key}: is gone.*{became}"):
        parse_settings(NfcGatewaySettings, {key: value}, "homebot.toml", "gateways.nfc")


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"devices": ["ftp:x"]}, "'ftp:x' is not a reader"),
        ({"tags": {"door": {}}}, "'door' is not the number of a tag"),
        ({"tags": {"04:a1:b2:c3": {}, "04A1B2C3": {}}}, "is there twice"),
    ],
)
def test_a_wrong_setting_is_named(table: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        NfcGatewaySettings.model_validate(table)
