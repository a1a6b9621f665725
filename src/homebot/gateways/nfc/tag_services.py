"""The services of an NFC gateway: find the device that a code points to, read a tag, write a tag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

import anyio

from homebot.conventions.nfc.ndef_message import read_ndef, write_ndef
from homebot.conventions.nfc.pointer import Pointer, pointer_of_code, pointer_of_device, pointer_of_records, records_for
from homebot.devices.device import KeyValue
from homebot.devices.names import TagNames
from homebot.devices.tags import (
    ReadTag,
    ReadTagRequest,
    ReadTagResponse,
    ScanCode,
    ScanCodeRequest,
    ScanCodeResponse,
    TagProblem,
    WriteTag,
    WriteTagRequest,
    WriteTagResponse,
)
from homebot.errors import WireError
from homebot.gateways.nfc.reader import ReaderDesk, TagSeen, WriteOrder
from homebot.support.bounded_map import BoundedMap

if TYPE_CHECKING:
    from homebot.gateways.nfc.device_finder import DeviceFinder, PointedAt
    from homebot.graph import Node

_MAX_READING: Final = 16
"""Calls that may wait for a tag at once."""

_MAX_WRITING: Final = 5.0
"""Seconds to wait for a tag that is being written when the time is up."""


class TagGateway(Protocol):
    """The gateway whose readers are used."""

    finder: DeviceFinder
    at_reader: BoundedMap[str, TagSeen]
    readers: dict[int, str]
    acts: bool
    observes_because: str

    def read(self, seen: TagSeen) -> Pointer:
        """Return the pointer on a tag."""
        ...


class TagServices:
    """Serves :class:`homebot.devices.tags.TagNames`."""

    def __init__(self, gateway: TagGateway, node: Node) -> None:
        self._gateway = gateway
        self._desks: list[ReaderDesk] = []
        self._next: anyio.Event = anyio.Event()
        self._shown: TagSeen | None = None
        self._reading = 0
        self._is_writing = False
        names = TagNames(node.name)
        node.create_service(ScanCode, names.scan, self._scan, concurrent=True)
        node.create_service(ReadTag, names.read_tag, self._read, concurrent=True, cancel_with_caller=True)
        node.create_service(WriteTag, names.write_tag, self._write, concurrent=True, cancel_with_caller=True)

    def open(self, desk: ReaderDesk) -> None:
        """Use the reader at *desk*."""
        self._desks.append(desk)

    def close(self, desk: ReaderDesk) -> None:
        """Stop using the reader at *desk*."""
        self._desks.remove(desk)

    def show(self, seen: TagSeen) -> None:
        """Pass a tag to the calls that wait for one."""
        self._shown = seen
        self._next.set()
        self._next = anyio.Event()

    def forget(self, uid: str) -> None:
        """Drop a tag that was taken away, for further calls."""
        if self._shown is not None and self._shown.uid == uid:
            self._shown = None

    async def _scan(self, request: ScanCodeRequest) -> ScanCodeResponse:
        try:
            pointer = pointer_of_records(read_ndef(request.ndef)) if request.ndef else pointer_of_code(request.text)
        except WireError as exc:
            return ScanCodeResponse(success=False, message=str(exc))
        if pointer.problems and not pointer.text:
            return ScanCodeResponse(success=False, message=pointer.problems[0])
        pointed = await self._gateway.finder.find(pointer)
        return ScanCodeResponse(
            success=True,
            message=_in_words(pointer, pointed),
            kind=pointer.kind,
            device=pointed.id,
            candidates=pointed.candidates,
            area=pointer.area,
            facts=tuple(KeyValue(key=key, value=value) for key, value in pointer.facts.items()),
        )

    async def _read(self, request: ReadTagRequest) -> ReadTagResponse:
        def failed(
            problem: TagProblem, message: str, tag: str = "", kind: str = "", reader: str = ""
        ) -> ReadTagResponse:
            return ReadTagResponse(
                success=False, message=message, problem=problem, tag=tag, tag_type=kind, reader=reader
            )

        if no_reader := self._why_no_reader(request.reader):
            return failed("no_reader", no_reader)
        if self._reading >= _MAX_READING:
            return failed("busy", "too many calls are waiting for a tag")
        self._reading += 1
        try:
            seen = await self._next_tag(request.reader, request.wait)
        finally:
            self._reading -= 1
        if seen is None:
            return failed("no_tag", _no_tag(request.wait))
        if seen.content is None:
            message = f"the tag {seen.uid} cannot be read: {seen.problem}"
            return failed("unreadable", message, seen.uid, seen.tag_type, seen.reader)
        pointer = self._gateway.read(seen)
        pointed = await self._gateway.finder.find(pointer)
        return ReadTagResponse(
            success=True,
            message=_in_words(pointer, pointed),
            tag=seen.uid,
            reader=seen.reader,
            tag_type=seen.tag_type,
            ndef=seen.content.message,
            device=pointed.id,
            candidates=pointed.candidates,
            area=pointer.area,
        )

    async def _write(self, request: WriteTagRequest) -> WriteTagResponse:
        def failed(problem: TagProblem, message: str) -> WriteTagResponse:
            return WriteTagResponse(success=False, message=message, problem=problem)

        if not self._gateway.acts:
            return failed("refused", self._gateway.observes_because)
        if no_reader := self._why_no_reader(request.reader):
            return failed("no_reader", no_reader)
        pointed = await self._gateway.finder.find(pointer_of_device(request.device))
        if pointed.device is None:
            many = f"several devices: {', '.join(pointed.candidates)}" if pointed.devices else "no known device"
            return failed("no_device", f"{request.device!r} is {many}")
        if self._is_writing:
            return failed("busy", "another call is writing a tag")
        self._is_writing = True
        try:
            order = await self._carry_out(
                write_ndef(*records_for(pointed.device.id, pointed.device.name, request.area)), request
            )
        finally:
            self._is_writing = False
        if order is None:
            return failed("no_tag", _no_tag(request.wait))
        return WriteTagResponse(
            success=order.error is None,
            message="" if order.error is None else f"the tag {order.tag} was not written: {order.error}",
            problem="" if order.error is None else order.error.problem,
            tag=order.tag,
            reader=order.used_reader,
            device=pointed.device.id,
        )

    async def _carry_out(self, message: bytes, request: WriteTagRequest) -> WriteOrder | None:
        """Have the next tag written, at any reader; None if none came in time."""
        order = WriteOrder(message, request.reader)
        desks = tuple(self._desks)
        for desk in desks:
            desk.place(order)
        try:
            with anyio.move_on_after(request.wait):
                await order.done.wait()
            if not order.claim():  # it is being written at this moment
                with anyio.move_on_after(_MAX_WRITING):
                    await order.done.wait()
        finally:
            for desk in desks:
                desk.withdraw(order)
        return order if order.done.is_set() else None

    async def _next_tag(self, reader: str, wait: float) -> TagSeen | None:
        wanted = reader.casefold()
        for seen in self._gateway.at_reader.values():
            if wanted in seen.reader.casefold():
                return seen
        with anyio.move_on_after(wait):
            while True:
                await self._next.wait()
                if self._shown is not None and wanted in self._shown.reader.casefold():
                    return self._shown
        return None

    def _why_no_reader(self, wanted: str) -> str:
        names = list(self._gateway.readers.values())
        if not names:
            return "no NFC reader is connected"
        if not any(wanted.casefold() in name.casefold() for name in names):
            return f"there is no reader {wanted!r}, only {', '.join(names)}"
        return ""


def _no_tag(wait: float) -> str:
    return f"no tag was held to a reader within {wait:g} s"


def _in_words(pointer: Pointer, pointed: PointedAt) -> str:
    if pointed.device is not None:
        return f"it points to {pointed.device.name}"
    if pointed.candidates:
        return f"it may point to any of {', '.join(pointed.candidates)}"
    return f"it points to {pointer.text}, which is not a known device" if pointer.text else "it points to nothing"
