"""Devices that wait for the owner's approval."""

from __future__ import annotations

from typing import Final, final

from homebot.control.device_lookup import DeviceLookup
from homebot.devices import Device
from homebot.devices.always_ask import waits_for_approval, why_device_asks
from homebot.devices.approval_messages import UnapprovedRequest, UnapprovedResponse
from homebot.devices.device import KeyValue
from homebot.devices.query import IsUnapproved
from homebot.errors import ServiceError

__all__ = ["Approvals"]

_MOST_NAMED: Final = 5


@final
class Approvals:
    """List of the devices that wait for approval.

    Attributes:
        is_needed: Whether devices need an approval at all; may be changed.
    """

    def __init__(self, lookup: DeviceLookup, *, is_needed: bool) -> None:
        self._lookup = lookup
        self.is_needed = is_needed

    async def unapproved(self, request: UnapprovedRequest) -> UnapprovedResponse:
        """Return the devices that wait, and the reasons why devices always ask."""
        if request.device:
            device = await self._lookup.device(request.device)
            found = [] if device is None else [device]
        else:
            found = await self._waiting()
        return UnapprovedResponse(
            devices=tuple(one.id for one in found if self.is_needed and waits_for_approval(one)),
            reasons=tuple(KeyValue(key=one.id, value=why) for one in found if (why := why_device_asks(one))),
        )

    async def notes(self) -> tuple[str, ...]:
        """Return a note on the devices that wait, for people; none if the directory does not answer."""
        try:
            waiting = await self._waiting()
        except ServiceError:
            return ()
        return (_waiting_note(waiting),) if waiting else ()

    async def _waiting(self) -> list[Device]:
        return list(await self._lookup.devices(IsUnapproved())) if self.is_needed else []


def _waiting_note(waiting: list[Device]) -> str:
    named = ", ".join(f"{one.id} ({why_device_asks(one)})" for one in waiting[:_MOST_NAMED])
    named += ", …" if len(waiting) > _MOST_NAMED else ""
    count = "1 device waits" if len(waiting) == 1 else f"{len(waiting)} devices wait"
    return f"{count} for approval, and nothing is sent before (`homebot approve DEVICE`): {named}"
