"""The values of a server's accessories, checked and reported."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.conventions.homekit.parts import PRESS, PRESSES
from homebot.conventions.payload import as_fields, compact_json, shown
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.homekit.accessory_device import AccessoryDevice
from homebot.gateways.homekit.port import HomekitValues
from homebot.support.numbers import whole_number

__all__ = ["ValueReports"]

_NO_POWER: Final = -70402
"""The HAP status code of an accessory that its bridge does not reach."""


class ValueReports:
    """Reports values, one message after the other.

    Args:
        server: The key of the server, the source of what breaks the rules.
        accessories: Its accessories by their IDs; the owner changes them.
    """

    def __init__(self, devices: PublishedDevices, server: str, accessories: Mapping[int, AccessoryDevice]) -> None:
        self._devices = devices
        self._server = server
        self._accessories = accessories

    async def report(self, values: HomekitValues, *, is_read: bool = False, is_routine: bool = False) -> None:
        """Report the values of an event or of a reading.

        Args:
            is_read: Whether they were read, which also says which accessories can be reached.
            is_routine: Whether only values that differ from the known ones are news.
        """
        news: dict[int, dict[int, object]] = {}
        for (aid, iid), fields in values.items():
            one, accessory = as_fields(fields), self._accessories.get(aid)
            known = None if accessory is None else accessory.find(iid)
            value = one.get("value")
            if accessory is None or known is None or not ("value" in one or is_read):
                self._reject(f"{aid}.{iid} {shown(fields)} is not the value of a characteristic that it has")
                continue
            if is_read:
                is_away = whole_number(one.get("status")) == _NO_POWER
                self._devices.report_reachable(accessory.device.key, reachable=not is_away)
            if known.type == PRESS and whole_number(value) not in PRESSES:
                if value is not None:  # as it is read
                    self._reject(f"{shown(value)} is not a press")
            elif "value" in one and not (is_routine and value == known.value):
                news.setdefault(aid, {})[iid] = value
        for aid, changed in news.items():
            await self._report(self._accessories[aid], changed)

    async def _report(self, accessory: AccessoryDevice, values: Mapping[int, object]) -> None:
        key = accessory.device.key
        self._devices.put(accessory.device, "it reported")
        for iid, value in values.items():
            payload = compact_json({"aid": accessory.aid, "iid": iid, "value": value})
            await self._devices.deliver_raw(key, payload.encode())
        for part in accessory.parts.values():
            changed = [one for one in part.service.characteristics.values() if one.iid in values]
            for one in changed:
                one.value = values[one.iid]
            kinds = {one.type for one in changed}
            for row in part.rows.values():  # each by itself: the newest report of each set of capabilities is kept
                if not kinds.isdisjoint(row.kinds):
                    await self._devices.report(key, {row.capability: row.read_value(part.service)}, part.part.id)

    def _reject(self, problem: str) -> None:
        self._devices.reject(self._server, b"", problem)
