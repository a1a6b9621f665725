"""Recorder: writes messages of gateways and commands as lines of a recording.

Messages of each kind are recorded in order. The time of a line is that of its message, so it does not matter when it is
recorded.
"""

from collections.abc import Iterator
from functools import partial
from typing import Final, TypeAlias, final

import anyio
from anyio.abc import TaskStatus

from homebot.devices import FIND_DEVICES, Devices, FindDevices, GatewayNames, RawMessage, Sighting, gateway_of
from homebot.devices.gateway_messages import GatewayState, Report
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.lease_messages import GetLeases, GetLeasesRequest, HeldPart
from homebot.devices.names import DIRECTORY_NODE, EXPORT_INDEX, GET_LEASES, JOURNAL_ENTRIES, OWNER_REQUESTS
from homebot.devices.places_messages import OwnerRequest
from homebot.devices.services import ExportIndex, ExportIndexRequest, FindDevicesRequest
from homebot.errors import InvalidNameError, RefusedError, ServiceError
from homebot.graph import DurabilityPolicy, EntityKind, Node, QoSProfile, Subscription
from homebot.messages import Time
from homebot.messages.message import Message
from homebot.recording.lines import (
    CommandNews,
    GatewayNews,
    LeaseNews,
    LostLines,
    RecordingEnd,
    RecordingHeader,
    RecordingLine,
    line_text,
)
from homebot.recording.repetitions import Repetitions
from homebot.recording.secrets import without_secrets

_MAX_LINES: Final = 50_000
_MAX_BYTES: Final = 64 * 1024 * 1024

NOT_RECORDED = "recording.raw_messages_missing"

_ALL_KEPT: Final = QoSProfile(depth=10_000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""In a flood the oldest is dropped and counted; see :meth:`Recorder.record_lost`."""

_ENTRIES: Final = QoSProfile(depth=10_000)


_Source: TypeAlias = (
    Subscription[JournalEntry] | Subscription[OwnerRequest] | Subscription[Sighting] | Subscription[Report]
)


@final
class Recorder:
    """Records events from its start."""

    def __init__(self, node: Node, header: RecordingHeader) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._header = header
        self._devices = Devices(node)
        self._commands = CommandNews()
        self._repetitions = Repetitions()
        self._gateways: set[str] = set()
        self._first_devices: frozenset[str] = frozenset()
        self._subscriptions: list[_Source] = []
        self._lost = 0
        self._started_at = self._clock.now()
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._export = node.create_client(ExportIndex, EXPORT_INDEX)
        self._leases = node.create_client(GetLeases, GET_LEASES)
        self.lines = LineBuffer()

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Record until cancelled."""
        held = (await self._leases.call(GetLeasesRequest())).parts
        devices = (await self._find.call(FindDevicesRequest())).devices
        rows = (await self._export.call(ExportIndexRequest())).rows
        self._started_at = self._clock.now()
        header = self._header.model_copy(update={"started_at": Time.from_seconds(self._started_at)})
        self._first_devices = frozenset(device.id for device in devices)
        self._record(self._started_at, header)
        for message in (*rows, *devices, *(news for part in held for news in _held(part))):
            self._record(self._started_at, message)
        with self._node.graph.watch() as changes:
            listen = self._node.create_subscription
            self._subscriptions += (
                listen(JournalEntry, JOURNAL_ENTRIES, self._on_entry, _ENTRIES),
                listen(OwnerRequest, OWNER_REQUESTS, self._on_request, _ENTRIES, from_node=DIRECTORY_NODE),
            )
            self._follow_gateways()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._follow_devices)
                task_status.started()
                async for change in changes:
                    if change.change == "added" and change.entity.kind is EntityKind.NODE:
                        self._follow_gateways()

    def record_lost(self) -> None:
        """Record the number of messages that were lost in floods since the last call."""
        lost = sum(subscription.lost for subscription in self._subscriptions)
        if lost > self._lost:
            self._record(self._clock.now(), LostLines(count=lost - self._lost))
            self._lost = lost

    def finish(self, reason: str = "") -> None:
        """Record the end."""
        self.record_lost()
        self._record(self._clock.now(), RecordingEnd(reason=reason))

    def _follow_gateways(self) -> None:
        for node in self._node.graph.get_node_names():
            gateway = gateway_of(node)
            if gateway and gateway not in self._gateways:
                self._gateways.add(gateway)
                self._follow(gateway)

    def _follow(self, gateway: str) -> None:
        try:
            names = GatewayNames(gateway)
            listen = partial(self._node.create_subscription, qos_profile=_ALL_KEPT, from_node=names.node)
            listen(GatewayState, names.state, partial(self._on_state, gateway))
            self._subscriptions += (
                listen(Sighting, names.received_topics, lambda one: self._record(one.seen_at.to_seconds(), one)),
                listen(Report, names.readings, lambda one: self._record(one.received_at.to_seconds(), one)),
            )
        except InvalidNameError:
            return  # no node can have such a name

    async def _follow_devices(self) -> None:
        async for change in self._devices.follow():
            if change.kind == "removed":
                continue
            if change.kind == "appeared" and change.device.id not in self._first_devices:
                self._record(self._clock.now(), change.device)
            try:
                await self._devices.listen(change.device, self._on_raw)
            except (RefusedError, ServiceError) as exc:
                self._node.log.warning(
                    NOT_RECORDED, message=f"the raw messages of {change.device.id} are not recorded: {exc}"
                )

    def _on_state(self, gateway: str, state: GatewayState) -> None:
        self._record(self._clock.now(), GatewayNews(gateway=gateway, state=state))

    def _on_raw(self, message: RawMessage) -> None:
        payload = without_secrets(message.payload)
        if payload != message.payload:
            message = message.model_copy(update={"payload": payload})
        self._record(message.received_at.to_seconds(), message)

    def _on_entry(self, entry: JournalEntry) -> None:
        if (news := self._commands.of(entry)) is not None:
            self._record(entry.at.to_seconds(), news)

    def _on_request(self, request: OwnerRequest) -> None:
        self._record(request.at.to_seconds(), request)

    def _record(self, at: float, message: Message) -> None:
        if not self.lines.add(RecordingLine(at - self._started_at, self._repetitions.shortened(message))):
            self._repetitions.forget()


def _held(part: HeldPart) -> Iterator[LeaseNews]:
    for holder in part.holders:
        yield LeaseNews(
            step="held",
            device=part.device,
            part=part.part,
            setting=part.setting,
            issuer=holder.issuer,
            by=holder.by,
        )


@final
class LineBuffer:
    """A buffer of at most 50,000 lines and 64 MiB of text; while full, it drops new lines, and a line counts them."""

    def __init__(self) -> None:
        self.lost = 0
        self._lines: list[str] = []
        self._bytes = 0
        self._gap = 0
        self._added = anyio.Event()

    def add(self, line: RecordingLine) -> bool:
        """Add a line, or count it if there is no room; return whether it was added."""
        text = line_text(line)
        if len(self._lines) >= _MAX_LINES or self._bytes + len(text) > _MAX_BYTES:
            self.lost += 1
            self._gap += 1
            return False
        if self._gap:
            self._put(line_text(RecordingLine(line.at, LostLines(count=self._gap))))
            self._gap = 0
        self._put(text)
        return True

    def pop(self, most: int = _MAX_LINES, most_bytes: int = _MAX_BYTES) -> list[str]:
        """Remove and return the oldest lines, at least one if there is any, without line breaks."""
        count, size = 0, 0
        for text in self._lines[:most]:
            if count and size + len(text) > most_bytes:
                break
            count, size = count + 1, size + len(text)
        taken, self._lines = self._lines[:count], self._lines[count:]
        self._bytes -= size
        if self.is_empty:
            self._added = anyio.Event()
        return taken

    async def wait(self) -> None:
        """Wait for a line."""
        await self._added.wait()

    @property
    def is_empty(self) -> bool:
        """True if no line waits."""
        return not self._lines

    def _put(self, text: str) -> None:
        self._lines.append(text)
        self._bytes += len(text)
        self._added.set()
