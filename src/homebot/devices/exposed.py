"""Exposure of homebot's own parts to other systems of the house, such as Home Assistant: its robot, apps, switches.

An offer goes to a gateway that publishes offers, on ``/gateway/<name>/offers``, and what it says of itself on
``/gateway/<name>/offer_reports``. Both topics are latched. What the other system tells it to do comes on
``/gateway/<name>/offer_commands`` as :class:`homebot.devices.command.Command`, with the offer's id as its key.
"""

from __future__ import annotations

from typing import ClassVar

from homebot.devices.part import Part
from homebot.devices.report import Reading
from homebot.messages.message import Message

__all__ = ["ExposedDevice", "ExposedState"]


class ExposedDevice(Message):
    """A device that homebot exposes to other systems, such as Home Assistant.

    Attributes:
        id: Unique in this homebot; keep it the same over restarts.
        name: The name for people.
        parts: Its parts.
        model: The model or kind, for people; may be empty.
        area: The room that it is in; empty if it has none.
        is_withdrawn: Whether it is no longer exposed.
    """

    key_field: ClassVar[str | None] = "id"

    id: str
    name: str
    parts: tuple[Part, ...]
    model: str = ""
    area: str = ""
    is_withdrawn: bool = False


class ExposedState(Message):
    """A reported state of something exposed.

    Attributes:
        id: Which offer.
        readings: What it says; kept until it says something else.
    """

    key_field: ClassVar[str | None] = "id"

    id: str
    readings: tuple[Reading, ...]
