"""The values that an accessory server sent, and that are not reported yet.

Of each characteristic the newest value waits; presses of buttons wait in their order, up to a limit. One task reports
them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import anyio

from homebot.conventions.homekit.sensors import PRESS, PRESSES
from homebot.conventions.payload import as_fields, compact_json, shown
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.homekit.accessory_device import AccessoryDevice
from homebot.gateways.homekit.port import HomekitValues
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
        self._values: dict[int, dict[int, object]] = {}
        self._presses: list[tuple[int, int, object]] = []
        self._filled = anyio.Event()

    def clear(self) -> None:
        """Drop all: the connection is new."""
        self._values, self._presses = {}, []

    def on_event(self, values: HomekitValues) -> None:
        """Put the values of an event into the queue; an accessory that breaks the rules too often is not heard."""
        if self._devices.admits(self._server):
            self.put(values)

    def put(self, values: HomekitValues, *, is_read: bool = False, is_routine: bool = False) -> None:
        """Put values into the queue.

        Args:
            is_read: Whether they were read, which also says which accessories can be reached.
            is_routine: Whether only values that differ from the known ones are news.
        """
        for (aid, iid), fields in values.items():
            one, accessory = as_fields(fields), self._accessories.get(aid)
            known = None if accessory is None else accessory.find(iid)
            if accessory is None or known is None or not ("value" in one or is_read):
                self._reject(f"{aid}.{iid} {shown(fields)} is not the value of a characteristic that it has")
                continue
            if is_read:
                is_away = whole_number(one.get("status")) == _NO_POWER
                self._devices.report_reachable(accessory.device.key, reachable=not is_away)
            value = one.get("value")
            if known.type == PRESS:
                self._put_press(aid, iid, value)
            elif "value" in one and not (is_routine and value == known.value):
                self._values.setdefault(aid, {})[iid] = value
        self._filled.set()

    async def report_all(self) -> None:
        """Report waiting values and presses until cancelled."""
        while True:
            await self._filled.wait()
            self._filled = anyio.Event()
            values, presses = self._values, self._presses
            self.clear()
            for aid, one in values.items():
                await self._report(aid, one)
            for aid, iid, press in presses:
                await self._report(aid, {iid: press})

    async def _report(self, aid: int, values: Mapping[int, object]) -> None:
        accessory = self._accessories[aid]
        key = accessory.device.key
        self._devices.put(accessory.device, "it reported")
        for iid, value in values.items():
            await self._devices.deliver_raw(key, compact_json({"aid": aid, "iid": iid, "value": value}).encode())
        for part in accessory.parts.values():
            changed = [one for one in part.service.characteristics.values() if one.iid in values]
            for one in changed:
                one.value = values[one.iid]
            kinds = {one.type for one in changed}
            for ability in part.abilities:  # each by itself, as the newest report of each set of capabilities is kept
                if not ability.watched.isdisjoint(kinds):
                    await self._devices.report(key, {ability.capability.name: ability.read()}, part.part.id)

    def _put_press(self, aid: int, iid: int, value: object) -> None:
        if value is None:  # as it is read
            return
        if whole_number(value) in PRESSES and len(self._presses) < MAX_PRESSES:
            self._presses.append((aid, iid, value))
        else:
            self._reject(f"{shown(value)} is not a press, or one too many")

    def _reject(self, problem: str) -> None:
        self._devices.reject(self._server, b"", problem)
