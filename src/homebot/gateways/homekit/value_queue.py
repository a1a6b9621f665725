"""The values that an accessory server sent, and that are not reported yet.

Of each characteristic the newest value waits; presses of buttons wait in their order, up to a limit. One task reports
them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Final

import anyio

from homebot.conventions.homekit.accessory import CharacteristicId
from homebot.conventions.homekit.sensors import PRESS, PRESSES
from homebot.conventions.payload import as_fields, compact_json, shown
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.homekit.accessory_device import AccessoryDevice
from homebot.support.numbers import whole_number

__all__ = ["ValueQueue"]

MAX_PRESSES: Final = 100

_NO_POWER: Final = -70402
"""The HAP status code of an accessory that its bridge does not reach."""


class ValueQueue:
    """The queue of one server.

    Args:
        server: The key of the server, the source of what breaks the rules.
        accessories: Its accessories by their IDs; the owner changes them.
    """

    def __init__(self, devices: PublishedDevices, server: str, accessories: Mapping[int, AccessoryDevice]) -> None:
        self._devices = devices
        self._server = server
        self._accessories = accessories
        self._values: dict[CharacteristicId, object] = {}
        self._presses: deque[tuple[int, int, str]] = deque()
        self._asked: set[CharacteristicId] = set()
        self._filled, self._is_asked = anyio.Event(), anyio.Event()

    def clear(self) -> None:
        """Drop all: the connection is new."""
        self._values.clear()
        self._presses.clear()
        self._asked.clear()
        self._filled, self._is_asked = anyio.Event(), anyio.Event()

    def ask_for(self, ids: Iterable[CharacteristicId]) -> None:
        """Have characteristics read."""
        self._asked.update(ids)
        self._is_asked.set()

    async def asked(self) -> list[CharacteristicId]:
        """Return the characteristics to read, waiting for some."""
        await self._is_asked.wait()
        self._is_asked = anyio.Event()
        ids, self._asked = sorted(self._asked), set()
        return ids

    def on_event(self, event: object) -> None:
        """Put the values of an event into the queue; an accessory that breaks the rules too often is not heard."""
        if self._devices.admits(self._server):
            self.put(event)

    def put(self, message: object, *, is_read: bool = False, is_routine: bool = False) -> None:
        """Put the values of a message into the queue.

        Args:
            message: The JSON of an event, or of a reading.
            is_read: Whether it is a reading, which also says which accessories can be reached.
            is_routine: Whether only values that differ from the known ones are news.
        """
        listed = as_fields(message).get("characteristics")
        if not isinstance(listed, list):
            self._reject(message, "not a list of characteristics")
            return
        for one in map(as_fields, listed):
            aid, iid = whole_number(one.get("aid")), whole_number(one.get("iid"))
            accessory = self._accessories.get(aid or 0)
            found = None if accessory is None or iid is None else accessory.find(iid)
            if accessory is None or found is None or not ("value" in one or is_read):
                self._reject(one, "not the value of a characteristic that it has")
                continue
            kind, known = found
            if is_read:
                is_away = whole_number(one.get("status")) == _NO_POWER
                self._devices.report_reachable(accessory.device.key, reachable=not is_away)
            if kind == PRESS:
                self._put_press(accessory.aid, known.iid, one.get("value"))
            elif "value" in one and not (is_routine and one["value"] == known.value):
                self._values[accessory.aid, known.iid] = one["value"]
        self._filled.set()

    async def report_all(self) -> None:
        """Report waiting values and presses until cancelled."""
        while True:
            await self._filled.wait()
            self._filled = anyio.Event()
            values, self._values = self._values, {}
            for accessory in tuple(self._accessories.values()):
                await self._report(
                    accessory, {iid: value for (aid, iid), value in values.items() if aid == accessory.aid}
                )
            while self._presses:
                aid, iid, press = self._presses.popleft()
                accessory = self._accessories[aid]
                part = next(one for one in accessory.parts.values() if one.service.characteristics[PRESS].iid == iid)
                self._devices.put(accessory.device, "it reported")
                await self._devices.report(accessory.device.key, {"press": press}, part.part.id)

    async def _report(self, accessory: AccessoryDevice, values: Mapping[int, object]) -> None:
        if not values:
            return
        key = accessory.device.key
        self._devices.put(accessory.device, "it reported")
        for iid, value in values.items():
            payload = compact_json({"aid": accessory.aid, "iid": iid, "value": value})
            await self._devices.deliver_raw(key, payload.encode())
        for part in accessory.parts.values():
            changed = {kind: one for kind, one in part.service.characteristics.items() if one.iid in values}
            for one in changed.values():
                one.value = values[one.iid]
            for ability in part.abilities:  # each by itself, as the newest report of each set of capabilities is kept
                if ability.read is not None and not ability.watched.isdisjoint(changed):
                    await self._devices.report(key, {ability.capability.name: ability.read()}, part.part.id)

    def _put_press(self, aid: int, iid: int, value: object) -> None:
        press = PRESSES.get(whole_number(value) or 0)
        if value is None or press is None or len(self._presses) >= MAX_PRESSES:
            if value is not None:
                self._reject(value, "not a press, or one too many")
        else:
            self._presses.append((aid, iid, press))

    def _reject(self, message: object, problem: str) -> None:
        self._devices.reject(self._server, str(message)[:200].encode(), f"{shown(message)} is {problem}")
