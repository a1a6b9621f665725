"""The link of ``[ros]``, as gateways of other machines of the house find it."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from homebot.bridges.ros2.session import ZenohSession


@final
class MachinesOnWire:
    """The session of the link, whose calls another task makes; None while there is none."""

    session: ZenohSession | None = None
