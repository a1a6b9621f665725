"""The gateway of NFC tags and QR codes, which point to devices."""

import importlib
from functools import partial
from typing import ClassVar, Final

import anyio
import anyio.to_thread
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.conventions.described_thing import DescribedThing
from homebot.conventions.nfc.ndef_message import load_ndef, read_ndef
from homebot.conventions.nfc.pointer import Pointer, pointer_of_device, pointer_of_records
from homebot.conventions.payload import clean_text
from homebot.devices.gateway_messages import Command
from homebot.devices.identity import identifiers
from homebot.devices.part import Part
from homebot.devices.tags import TagTap
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.gateways.nfc.device_finder import DeviceFinder, PointedAt, RoomTagger
from homebot.gateways.nfc.reader import (
    ReaderDesk,
    ReaderNews,
    TagLeft,
    TagReader,
    TagReaders,
    TagSeen,
    read_tags,
)
from homebot.gateways.nfc.settings import NfcGatewaySettings, TagSettings
from homebot.gateways.nfc.tag_services import TagServices
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time
from homebot.plugins import check_extra
from homebot.support.backoff import Backoff, BackoffCounter
from homebot.support.bounded_map import BoundedMap
from homebot.support.isolation import run_as

READER_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=10.0, late_cap=30.0, late_after=300.0, jitter=0.5)
"""For a reader that is not connected."""

STEADY_AFTER: Final = 60.0
"""Seconds after which a reader that fails counts as a first failure."""

_MAX_AT_READERS: Final = 64
"""Tags at readers at once; then the oldest is forgotten: a reader may not report that one leaves."""

_TAG: Final = simple_part("x_tag", readable=("scan", "connectivity"))
_RANDOM_UID: Final = 8
"""Hexadecimal digits of a random number, which begins with 08 and changes each time, as phones do
(ISO/IEC 14443-3, 6.5.4)."""


class NfcGateway(Gateway):
    """Brings tags at NFC readers onto the graph, and answers which device a tag or a code points to.

    Args:
        context: Services of its host; :class:`TagReaders` replace the readers in its settings.

    Attributes:
        devices: The tags, and the devices that only a tag describes.
        at_reader: The tags that are at a reader now, by their numbers.
        readers: The names of the connected readers, by their places in the settings.
    """

    Settings: ClassVar[type[BaseModel]] = NfcGatewaySettings

    def __init__(
        self, node: Node, settings: NfcGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        settings = settings or NfcGatewaySettings()
        super().__init__(node, settings, context)
        self._settings = settings
        self.devices = PublishedDevices(self, self._perform, settings, max_devices=2 * settings.max_tags)
        self.finder = DeviceFinder(node)
        self.at_reader: BoundedMap[str, TagSeen] = BoundedMap(_MAX_AT_READERS)
        self.readers: dict[int, str] = {}
        self._problems: dict[int, str] = {}
        self._sides: list[TagReader] = []
        self._handling = anyio.Lock()
        self._was_tried = anyio.Event()
        self._taps = node.create_publisher(TagTap, "~/taps")
        self._services = TagServices(self, node)
        self._room_tagger = RoomTagger(node) if settings.teaches_place else None

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Look for the libraries."""
        del settings
        check_extra('the gateway "nfc"', "nfc", "ndef", "nfc")

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the readers until cancelled; ready after the first attempt with each."""
        await anyio.to_thread.run_sync(load_ndef)
        self._sides = await self._make_readers()
        async with anyio.create_task_group() as tasks:
            for number, reader in enumerate(self._sides):
                tasks.start_soon(run_as, self.node.full_name, partial(self._follow, number, reader))
            await self._was_tried.wait()
            task_status.started()

    async def _make_readers(self) -> list[TagReader]:
        given = self.context.service(TagReaders)
        if given is not None:
            return list(given.readers)
        await anyio.to_thread.run_sync(importlib.import_module, "nfc")  # it looks for OpenSSL by running ldconfig
        from homebot.gateways.nfc.nfcpy_reader import NfcpyReader  # noqa: PLC0415 - an extra

        return [NfcpyReader(device) for device in self._settings.devices]

    async def _follow(self, number: int, reader: TagReader) -> None:
        retries = BackoffCounter(self.node.graph.clock, self.random, STEADY_AFTER)
        while True:
            retries.begin()
            desk = ReaderDesk(partial(self._on_report, number))
            self._services.open(desk)
            try:
                await read_tags(reader, desk)
            except LinkError as exc:
                self._problems[number] = str(exc)
            else:
                self._problems[number] = "the reader stopped"
            finally:
                self._services.close(desk)
            self.readers.pop(number, None)
            await self._lose_tags()
            await anyio.sleep(retries.fail(READER_BACKOFF))

    async def _on_report(self, number: int, news: ReaderNews) -> None:
        """Handle a report of a reader, one after the other."""
        async with self._handling:
            if isinstance(news, TagSeen):
                await self._handle_tag(news)
            elif isinstance(news, TagLeft):
                await self._lose_tag(news.uid)
            else:
                self.readers[number] = news.reader
                self._problems.pop(number, None)
                await self._lose_tags()

    async def _lose_tags(self) -> None:
        """Report that the tags at readers that are not connected any more were taken away."""
        self._show_state()
        connected = set(self.readers.values())
        for uid in [uid for uid, seen in self.at_reader.items() if seen.reader not in connected]:
            await self._lose_tag(uid)

    async def _lose_tag(self, uid: str) -> None:
        self._services.forget(uid)
        if self.at_reader.pop(uid, None) is not None and uid in self.devices.keys:
            await self.devices.report(uid, {"connectivity": False})

    def _show_state(self) -> None:
        """Publish whether any reader works, after the first attempt with each."""
        tried = {*self.readers, *self._problems}
        if len(tried) < len(self._sides):
            return
        if self.readers:
            self.publish_state("active")
        else:
            self.publish_state("unavailable", "; ".join(dict.fromkeys(self._problems.values())))
        self._was_tried.set()

    async def _handle_tag(self, seen: TagSeen) -> None:
        if not self.devices.admits(seen.uid):
            return
        if seen.content is None:
            self.devices.reject(seen.uid, b"", f"{seen.uid or 'something'} at {seen.reader}: {seen.problem}")
        pointer = self.read(seen)
        if seen.uid:
            self.at_reader[seen.uid] = seen
            pointed = await self.finder.find(pointer)
            is_random = len(seen.uid) == _RANDOM_UID and seen.uid.startswith("08")
            if seen.uid in self._settings.tags or not (is_random or pointer.problems):
                self.devices.put(self._describe(seen, pointer, pointed), f"it was held to {clean_text(seen.reader)}")
                await self.devices.deliver_raw(seen.uid, seen.content.message if seen.content else b"")
                await self.devices.report(seen.uid, {"connectivity": True})
                await self.devices.report(seen.uid, {"scan": seen.uid})
            if pointer.thing is not None and not pointed.devices:
                self._publish_thing(pointer.thing, seen)
            self._taps.publish(
                TagTap(
                    tag=seen.uid,
                    reader=seen.reader,
                    points_to=pointer.text,
                    device=pointed.id,
                    candidates=pointed.candidates,
                    area=pointer.area,
                    tapped_at=Time.from_seconds(self.node.graph.clock.now()),
                )
            )
            if self._room_tagger is not None and pointed.id:
                await self._room_tagger.assign_room(seen.uid, pointed.id, pointer.area)
        self._services.show(seen)

    def read(self, seen: TagSeen) -> Pointer:
        """Return the pointer on a tag, or the one in the settings; invalid records are counted."""
        own = self._settings.tags.get(seen.uid, TagSettings())
        message = b"" if seen.content is None else seen.content.message
        try:
            pointer = pointer_of_records(read_ndef(message))
        except WireError as exc:
            pointer = Pointer(problems=(str(exc),))
        if pointer.problems:
            self.devices.reject(seen.uid, message, f"the tag {seen.uid}: {pointer.problems[0]}")
        if own.device:
            pointer = pointer_of_device(own.device)
        return Pointer(area=own.area).joined(pointer) if own.area else pointer

    def _describe(self, seen: TagSeen, pointer: Pointer, pointed: PointedAt) -> GatewayDevice:
        own = self._settings.tags.get(seen.uid, TagSettings())
        facts = {
            "tag": seen.uid,
            "tag_type": seen.tag_type,
            "points_to": pointer.text,
            "device": pointed.id,
        }
        return GatewayDevice(
            key=seen.uid,
            name=own.name or f"Tag {seen.uid}",
            parts=(_TAG,),
            metadata={name: text for name, text in facts.items() if text},
            identifiers=identifiers([f"nfc {seen.uid} tag"]),
            area=pointer.area,
            raw_address=f"tag/{seen.uid}",
        )

    def _publish_thing(self, thing: DescribedThing, seen: TagSeen) -> None:
        """Publish a device that only this tag describes; it takes no commands."""
        if not thing.identifiers:
            self.devices.reject(seen.uid, b"", f"the tag {seen.uid} describes a Thing without an id")
            return
        self.devices.put(
            GatewayDevice(
                key=f"thing {thing.identifiers[0]}",
                name=thing.title or thing.identifiers[0],
                parts=(Part(id="", service_type="x_unknown"),),
                metadata={**thing.facts, "described_by": f"tag {seen.uid}"},
                identifiers=thing.identifiers,
                area=thing.area,
            ),
            f"the tag {seen.uid} describes it",
            confirmed=False,
        )

    async def _perform(self, command: Command) -> None:
        raise RefusedError(command.key, "tags take no commands")
