"""Ends of confirmed values soon after the confirmation: noted, logged and published."""

from __future__ import annotations

from typing import TypeAlias, final

from homebot.control.journal import CommandJournal
from homebot.control.timeline.cause import Cause, cause_of_undoing
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.command_messages import CommandEvent
from homebot.devices.command_results import result_of
from homebot.devices.names import COMMAND_EVENTS
from homebot.devices.outcomes import Reverted
from homebot.graph import Node

__all__ = ["Undoings"]

REVERTED = "control.reverted"

_Place: TypeAlias = tuple[str, str]


@final
class Undoings:
    """Publishes the events of commands whose confirmed value ended.

    Args:
        node: The node that publishes them.
        journal: Notes them.
        is_watched: Whether the owner wants to know.
    """

    def __init__(self, node: Node, journal: CommandJournal, *, is_watched: bool) -> None:
        self._node = node
        self._journal = journal
        self._is_watched = is_watched
        self._events = node.create_publisher(CommandEvent, COMMAND_EVENTS, 1000)

    def publish(self, place: _Place, progress: CommandProgress) -> None:
        """Publish the end of the confirmed value of a part."""
        settling, order = progress.settling, progress.order
        if settling is None or settling.undoing is None or not self._is_watched:
            return
        is_usual = cause_of_undoing(progress, settling.undoing.capability) is Cause.DEVICE
        outcome = Reverted(settling.undoing.after, "device" if is_usual else "unknown", command_id=order.id)
        result, (device, part) = result_of(outcome), place
        self._journal.reverted(place, order.id, order.issuer, result)
        self._events.publish(CommandEvent(device=device, part=part, issuer=order.issuer, result=result))
        self._node.log.warning(REVERTED, message=f"{order.label}: {outcome.text}", device=device, command=order.id)
