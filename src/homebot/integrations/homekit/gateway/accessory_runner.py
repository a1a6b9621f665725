"""The work with one paired accessory server: connects, describes its accessories, reports their values, and writes.

An accessory sends no event to the controller that wrote, so written values are read back. All values are read at
intervals, because some have no events, and to check that the accessory is still there. Values are reported in order; if
too many events wait, further ones are dropped, and all values are read.

Source: HomeKit Accessory Protocol Specification R2, 8.1 (Accessory Information), 2.5.3.2 (bridges).
"""

import asyncio
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

import anyio
from anyio.abc import TaskGroup

from homebot.conventions.capability_row import writer_of
from homebot.conventions.joint_message import join
from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.conventions.payload import as_fields, compact_json, shown
from homebot.devices.gateway_messages import Command
from homebot.devices.identity import identifiers, may_be_unique
from homebot.errors import LinkError, RefusedError
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.integrations.homekit.formats.accessory import (
    Accessory,
    CharacteristicId,
    HapCharacteristic,
    parse_accessories,
)
from homebot.integrations.homekit.formats.parts import PRESS, PRESSES, HomekitPart, parts_of
from homebot.integrations.homekit.gateway.port import FoundAccessory, HomekitLink, HomekitPort, HomekitValues, Pairing
from homebot.support.backoff import Backoff
from homebot.support.numbers import whole_number

_NAME, _SERIAL = "23", "30"
_FACTS: Final = {"manufacturer": "20", "model": "21", "sw_version": "52", "hw_version": "53"}
_FIRST: Final = 1
"""The accessory ID of a standalone accessory, and of a bridge."""


def key_of(server: str, aid: int) -> str:
    """Return the key of an accessory: the pairing ID of its server, plus its accessory ID behind a bridge."""
    return server if aid == _FIRST else f"{server}.{aid}"


@dataclass(frozen=True, slots=True)
class AccessoryDevice:
    """An accessory, with its accessory ID, device and parts."""

    aid: int
    device: GatewayDevice
    parts: Mapping[str, HomekitPart]

    def find(self, iid: int) -> HapCharacteristic | None:
        """Return a characteristic of its parts, or None for an unknown *iid*."""
        known = (
            characteristic for part in self.parts.values() for characteristic in part.service.characteristics.values()
        )
        return next((characteristic for characteristic in known if characteristic.iid == iid), None)


def describe(sighted: FoundAccessory, accessory: Accessory | None = None) -> AccessoryDevice:
    """Return an accessory as a device; without parts if it is not paired."""
    known = accessory or Accessory(_FIRST)
    key, information, is_first = key_of(sighted.id, known.aid), known.information, known.aid == _FIRST
    parts = {part.part.id: part for part in parts_of(known)}
    texts = {fact: known.information.text(kind) for fact, kind in _FACTS.items()}
    texts["model"] = texts["model"] or sighted.model
    texts["via_device"] = "" if known.aid == _FIRST else sighted.id
    facts = {fact: text for fact, text in texts.items() if text}
    own = "pairing" if is_first else f"aid {known.aid}"
    serial = information.text(_SERIAL)
    device = GatewayDevice(
        key,
        information.text(_NAME) or sighted.name,
        tuple(part.part for part in parts.values()),
        facts,
        identifiers(
            [
                f"homekit {sighted.id.upper()} {own}",
                *([serial] if may_be_unique(serial, facts.get("model", "")) else []),
            ]
        ),
        whole_device=True,
        authenticated=accessory is not None,  # it has proved the key of its pairing
        service_type="" if parts else sighted.service_type,
        raw_address=f"homekit/{key}",
        sleeps=known.sleeps,
    )
    return AccessoryDevice(known.aid, device, parts)


LOST_BACKOFF: Final = Backoff(first=0.5, factor=2.0, cap=2.0, late_cap=15.0, late_after=300.0, jitter=0.5)
"""An accessory that restarts is back within seconds."""

CONNECTED_WITHIN: Final = 5.0
"""Seconds for which a command waits for a connection."""

AWAKE_WITHIN: Final = 30.0
"""Seconds for which it waits for the connection to a sleepy accessory."""

READ_EVERY, READ_SLEEPER_EVERY = 30.0, 300.0
"""Seconds between readings of all values, which drain batteries."""

MAX_EVENTS: Final = 100

_NO_POWER: Final = -70402
_LINK_PROBLEMS: Final = {
    _NO_POWER: "its bridge does not reach it",
    -70403: "it is busy",
    -70407: "it has no memory left",
    -70408: "it took too long",
}
"""By HAP status code (table 6-11)."""


class AccessoryRunner(DeviceRunner):
    """The runner of a paired accessory, or of a bridge and the accessories behind it.

    Attributes:
        sleeps: Whether its radio is off most of the time, so that a lost connection does not mean that it is away.
    """

    def __init__(self, sighted: FoundAccessory, pairing: Pairing, devices: PublishedDevices, port: HomekitPort) -> None:
        super().__init__(sighted.name, sighted.id, devices, LOST_BACKOFF)
        self.link: HomekitLink | None = None
        self._found = sighted
        self._pairing = pairing
        self._port = port
        self.sleeps = sighted.is_on_thread  # possible, until it describes itself
        self._attempt_ended, self._doubted = anyio.Event(), anyio.Event()
        self._accessories: dict[int, AccessoryDevice] = {}
        self._waiting = asyncio.Queue[Callable[[], Awaitable[None]]](MAX_EVENTS)
        self._tasks: TaskGroup | None = None
        self._writes = 0

    @property
    def keys(self) -> frozenset[str]:
        """The keys of its devices."""
        return frozenset({self.key, *(accessory.device.key for accessory in self._accessories.values())})

    def change(self, sighted: FoundAccessory) -> None:
        """Use the new announcement of the accessory; reconnect if its accessories have changed.

        If values or its address have changed, all values are read at once, which also tests the connection, as anyone
        can announce its ID.
        """
        before, self._found = self._found, sighted
        self.name = sighted.name
        has_moved = (sighted.address, sighted.port) != (before.address, before.port)
        # a cancelled attempt leaves a socket of aiocoap open
        is_left_alone = self.link is None and sighted.is_on_thread
        if not is_left_alone and (sighted.version != before.version or (has_moved and self.link is None)):
            self.restart()
        elif has_moved or sighted.state != before.state:
            self._doubted.set()
        self.wake()

    async def work(self) -> None:
        """Connect, describe the accessories, and relay their values until the connection is lost."""
        self._waiting = asyncio.Queue(MAX_EVENTS)
        async with self._port.connected(self._found, self._pairing, self._on_event) as link:
            before, accessories = self.keys, parse_accessories(await link.list_accessories())
            self.sleeps = any(accessory.sleeps for accessory in accessories.values())
            self._accessories.clear()
            for aid, accessory in accessories.items():
                self._accessories[aid] = described = describe(self._found, accessory)
                self._devices.put(described.device, "it described itself")
            for key in before - self.keys:
                self._devices.remove(key, "its bridge no longer has it")
            await link.subscribe(self._ids("ev"))
            await self._report(await link.read(self._ids("pr")), is_read=True)
            self.link = link
            self.on_answer()
            self._attempt_ended.set()
            async with anyio.create_task_group() as self._tasks:
                self._tasks.start_soon(self._report_waiting)
                self._tasks.start_soon(self._read_all, link)
                try:
                    await link.lost.wait()
                finally:
                    self.link = None  # no command starts a task any more
                self._tasks.cancel_scope.cancel()
        raise LinkError(f"the connection to {self.name} was lost")

    def list_unheard(self) -> None:
        """Publish the accessory as it is announced."""
        self._devices.put(describe(self._found).device, "it is paired, and was not reached yet", confirmed=False)

    def on_end(self) -> None:
        """Publish the loss of the connection."""
        self.link = None
        self._attempt_ended.set()
        self._attempt_ended = anyio.Event()
        super().on_end()
        for key in self.keys - {self.key}:
            self._devices.report_reachable(key, reachable=None if self.sleeps else False)

    async def perform(self, command: Command) -> Collection[str]:
        """Carry out *command*; without a connection, wait for one (for one attempt unless it is sleepy)."""
        link = await self._wait_until_connected()
        accessory, part = self._find(command)
        known = part.service.characteristics

        def write(setting: Command) -> Mapping[str, object]:
            written = writer_of(part.rows.values(), setting.capability)(part.service, setting)
            return written if setting.capability in LIGHT_CAPABILITIES else {**written, "": setting.capability}

        message, along = join(command, write)
        watched = {kind for setting in (command.capability, *along) for kind in part.rows[setting].watched}
        wanted = {
            known[kind]: known[kind].encode(value)
            for kind, value in message.items()
            if isinstance(value, int | float) and kind in known
        }
        self._writes += 1
        statuses = await link.write(
            {(accessory.aid, characteristic.iid): value for characteristic, value in wanted.items()},
            is_timed=any("tw" in characteristic.perms for characteristic in wanted),
        )
        for status in statuses.values():
            raise _error_of(f"{command.capability} for {accessory.device.name}", status)
        for characteristic, value in wanted.items():
            # the next command, before it is read back, may depend on it: a temperature on a mode
            characteristic.value = value
        ids = {
            (accessory.aid, characteristic.iid)
            for characteristic in known.values()
            if "pr" in characteristic.perms and (characteristic in wanted or characteristic.type in watched)
        }
        if ids and self._tasks is not None and self.link is link:
            self._tasks.start_soon(self._read, link, ids)
        return along

    def _find(self, command: Command) -> tuple[AccessoryDevice, HomekitPart]:
        """Return the accessory and the part with the capability of a command, as last described."""
        for accessory in self._accessories.values():
            part = accessory.parts.get(command.part)
            if accessory.device.key == command.key and part is not None and command.capability in part.rows:
                return accessory, part
        raise self.not_connected()

    async def _wait_until_connected(self) -> HomekitLink:
        """Wait for the connection and return it; raise LinkError if there is none in time."""
        if self.link is None:
            self.wake()
            with anyio.move_on_after(AWAKE_WITHIN if self.sleeps else CONNECTED_WITHIN):
                await self._attempt_ended.wait()
                while self.sleeps and self.link is None:
                    await self._attempt_ended.wait()
        if self.link is None:
            raise self.not_connected()
        return self.link

    def _ids(self, permission: str) -> list[CharacteristicId]:
        """Return the characteristics of known capabilities with a permission."""
        return sorted(
            (aid, characteristic.iid)
            for aid, accessory in self._accessories.items()
            for part in accessory.parts.values()
            for characteristic in part.service.characteristics.values()
            if permission in characteristic.perms
            and any(characteristic.type in row.watched for row in part.rows.values())
        )

    def _on_event(self, values: HomekitValues) -> None:
        """Queue the values of an event for reporting, unless the accessory breaks the rules too often."""
        if not self._devices.admits(self.key):
            return
        if self._waiting.full():
            self.reject(b"", f"{self.name} sends more events than can be reported")
            self._doubted.set()
        else:
            self._waiting.put_nowait(partial(self._report, values))

    async def _report_waiting(self) -> None:
        while True:
            report = await self._waiting.get()
            await report()

    async def _read(self, link: HomekitLink, ids: Collection[CharacteristicId]) -> None:
        await self._waiting.put(partial(self._report, await link.read(ids), is_read=True))

    async def _read_all(self, link: HomekitLink) -> None:
        """Read all values at intervals; values read while a command was sent may be older than it."""
        while True:
            with anyio.move_on_after(READ_SLEEPER_EVERY if self.sleeps else READ_EVERY):
                await self._doubted.wait()
            self._doubted = anyio.Event()
            writes = self._writes
            values = await link.read(self._ids("pr"))
            if writes == self._writes:
                await self._waiting.put(partial(self._report, values, is_read=True, is_routine=True))
            await self._waiting.put(partial(self._devices.confirm, self.keys, "it answers"))

    async def _report(self, values: HomekitValues, *, is_read: bool = False, is_routine: bool = False) -> None:
        """Check and report the values of an event or of a reading.

        Args:
            is_read: Whether they were read, which also tells which accessories can be reached.
            is_routine: Whether to report only values that differ from the known ones.
        """
        news: dict[int, dict[int, object]] = {}
        for (aid, iid), fields in values.items():
            entry, accessory = as_fields(fields), self._accessories.get(aid)
            known = None if accessory is None else accessory.find(iid)
            if accessory is None or known is None or not ("value" in entry or is_read):
                self.reject(b"", f"{aid}.{iid} {shown(fields)} is not the value of a characteristic that it has")
                continue
            if is_read:
                is_away = whole_number(entry.get("status")) == _NO_POWER
                self._devices.report_reachable(accessory.device.key, reachable=not is_away)
            value = entry.get("value")
            if known.type == PRESS and whole_number(value) not in PRESSES:
                if value is not None:  # as it is read
                    self.reject(b"", f"{shown(value)} is not a press")
                is_news = False
            else:
                is_old = is_routine and value == known.value
                known.value = value  # None for one that could not be read, so the next one is news
                is_news = "value" in entry and not is_old
            if is_news:
                news.setdefault(aid, {})[iid] = entry["value"]
        for aid, changed in news.items():
            await self._report_changed(self._accessories[aid], changed)

    async def _report_changed(self, accessory: AccessoryDevice, values: Mapping[int, object]) -> None:
        key = accessory.device.key
        self._devices.put(accessory.device, "it reported")
        for iid, value in values.items():
            payload = compact_json({"aid": accessory.aid, "iid": iid, "value": value})
            await self._devices.deliver_raw(key, payload.encode())
        for part in accessory.parts.values():
            kinds = {
                characteristic.type
                for characteristic in part.service.characteristics.values()
                if characteristic.iid in values
            }
            for row in part.rows.values():  # one by one, as the newest report of each set of capabilities is kept
                if row.read is not None and not kinds.isdisjoint(row.watched):
                    await self._devices.report(key, {row.capability: row.read(part.service)}, part.part.id)


def _error_of(what: str, status: int) -> LinkError | RefusedError:
    code = -abs(status)  # some accessories omit the sign
    if code in _LINK_PROBLEMS:
        return LinkError(f"{what} was not set: {_LINK_PROBLEMS[code]}")
    return RefusedError(what, f"HAP status {code}", code)
