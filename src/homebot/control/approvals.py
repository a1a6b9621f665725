"""The devices that wait for the owner's approval, for who asks and for the health of the control layer."""

from __future__ import annotations

from contextlib import closing
from typing import Final, final

from homebot.devices import FIND_DEVICES, FindDevices
from homebot.devices.approval_messages import UnapprovedRequest, UnapprovedResponse
from homebot.devices.query import And, FactIs, IsUnapproved, query_terms
from homebot.devices.services import FindDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node

__all__ = ["Approvals"]

_MOST_NAMED: Final = 5


@final
class Approvals:
    """Tells which devices wait for approval.

    Args:
        node: The node that asks the directory.
        is_needed: Whether devices need an approval at all.
    """

    def __init__(self, node: Node, *, is_needed: bool) -> None:
        self._node = node
        self._is_needed = is_needed

    async def unapproved(self, request: UnapprovedRequest) -> UnapprovedResponse:
        """Return the devices that wait."""
        return UnapprovedResponse(devices=await self._waiting(request.device))

    async def notes(self) -> tuple[str, ...]:
        """Return a note on the devices that wait, for people; none where the directory does not answer."""
        try:
            waiting = await self._waiting()
        except ServiceError:
            return ()
        return (_note(waiting),) if waiting else ()

    async def _waiting(self, device: str = "") -> tuple[str, ...]:
        if not self._is_needed:
            return ()
        query = And((IsUnapproved(), FactIs("id", device.casefold()))) if device else IsUnapproved()
        with closing(self._node.create_client(FindDevices, FIND_DEVICES)) as find:
            found = (await find.call(FindDevicesRequest(query=query_terms(query)))).devices
        return tuple(one.id for one in found if device in {"", one.id})


def _note(waiting: tuple[str, ...]) -> str:
    named = ", ".join(waiting[:_MOST_NAMED]) + (", …" if len(waiting) > _MOST_NAMED else "")
    count = "1 device waits" if len(waiting) == 1 else f"{len(waiting)} devices wait"
    return f"{count} for approval, and only locks, closes or stops until then (`homebot approve DEVICE`): {named}"
