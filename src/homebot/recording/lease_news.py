"""Steps of leases, for a recording."""

from __future__ import annotations

from typing import Literal, TypeAlias

from homebot.devices.command_messages import Setting
from homebot.messages.message import Message

__all__ = ["LeaseNews", "RecordedLeaseStep"]

RecordedLeaseStep: TypeAlias = Literal["held", "released", "ended", "expired"]


class LeaseNews(Message):
    """A step of a lease.

    Attributes:
        step: ``held``: *by* began to hold the part, or held it when the recording began; ``released``: it let go;
            ``ended``: *issuer* ended the leases of the device; ``expired``: the time of *by* was over.
        device: The id of the device.
        part: The id of the part.
        setting: What is held.
        issuer: Who holds it, or ended it: the name of a node, or ``client:NAME`` for a client of the door.
        by: The holder, in a word.
    """

    step: RecordedLeaseStep
    device: str
    part: str = ""
    setting: Setting
    issuer: str
    by: str = ""
