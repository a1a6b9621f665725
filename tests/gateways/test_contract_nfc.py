"""The gateway of tags keeps the contract: a tag is on while it is at the reader, which nfcpy drives over UDP."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from tests.gateways.nfc.world import UID, uri
from tests.patience import PATIENCE
from tests.simulated.nfc.field import TagField
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.ndef_message import TagContent
from homebot.errors import LinkError
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.nfc import NfcGateway, NfcGatewaySettings
from homebot.gateways.nfc.nfcpy_reader import NfcpyReader
from homebot.gateways.nfc.reader import ReaderDesk, TagReader, TagReaders
from homebot.graph import Node
from homebot.testing.gateway_contract import GatewayContract, Lamp

MESSAGE = uri("homebot:device/lights/hall")


class StrangeTag:
    """A tag whose message is none."""

    tag_type = "strange"

    def __init__(self, number: int) -> None:
        self.uid = f"04{number:012x}"

    def read(self) -> TagContent:
        """A record that is longer than the tag; long, so that few use up a budget, however slowly they are read."""
        return TagContent(b"\xc1\x01\xff\xff\xff\xffU" + b"?" * 20_000, 30_000, is_writable=True)

    def write(self, message: bytes) -> None:
        raise NotImplementedError


class PluggedReader(TagReader):
    """nfcpy's reader on a cable that can be pulled."""

    def __init__(self, path: str) -> None:
        self.is_plugged = True
        self.is_besieged = False
        self._reader = NfcpyReader(path)

    def run(self, desk: ReaderDesk) -> None:
        if self.is_plugged:
            self._reader.run(PluggedDesk(self, desk))
        if not desk.is_stopped:
            raise LinkError("the reader is not plugged in")

    def besiege(self, desk: ReaderDesk) -> None:
        self.is_besieged = False
        for number in range(2000):
            desk.arrived("reader", StrangeTag(number))


class PluggedDesk(ReaderDesk):
    """A desk that is stopped while its reader is not plugged in."""

    def __init__(self, reader: PluggedReader, desk: ReaderDesk) -> None:
        super().__init__(desk._report)
        self._reader = reader
        self._desk = desk

    @property
    def is_stopped(self) -> bool:
        if self._reader.is_besieged:
            self._reader.besiege(self._desk)
        return self._desk.is_stopped or not self._reader.is_plugged

    def wait(self, seconds: float) -> bool:
        return self._desk.wait(seconds) or self.is_stopped


class HallTag(Lamp):
    """A tag in the hall."""

    service_type = "x_tag"
    capability = "connectivity"
    gateway: NfcGateway

    def __init__(self, field: TagField) -> None:
        super().__init__(UID, address=f"tag/{UID}")
        self.field = field
        self.reader = PluggedReader(field.path)

    async def announce(self) -> None:
        await self.report(on=True)
        await self.report(on=False)

    async def report(self, *, on: bool) -> None:
        """Come to the reader, or leave it, and wait until it has noticed: who is too quick was never there."""
        self.field.card = Type4Card(bytes.fromhex(UID), MESSAGE) if on else None
        with anyio.fail_after(PATIENCE):
            while (UID in self.gateway.at_reader) is not on:  # noqa: ASYNC110 - a reader tells the gateway alone
                await anyio.sleep(0.02)

    def raw(self, *, on: bool) -> bytes:
        del on
        return MESSAGE

    async def misbehave(self) -> None:
        self.reader.is_besieged = True

    async def withdraw(self) -> None:
        """Nobody says of a tag that it was thrown away."""

    async def told(self) -> bool | None:
        return None

    async def lose_link(self) -> None:
        self.reader.is_plugged = False

    async def mend_link(self) -> None:
        self.reader.is_plugged = True

    async def meet_again(self) -> None:
        await self.announce()


class TestNfcGateway(GatewayContract):
    """One tag."""

    name = "nfc"
    takes_commands = False
    tells_goodbye = False

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        field = TagField()
        async with field.served():
            yield HallTag(field)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, HallTag)
        table = {"tags": {UID: {"name": lamp.name}}, **settings}
        return NfcGateway(node, NfcGatewaySettings.model_validate(table), GatewayContext.of(TagReaders((lamp.reader,))))
