"""The trigger of a command: a report, a change of a device, a raw message or a timer, with its facts."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from homebot.devices.device import DeviceChange, StateChange
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.value import Reading
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.graph.timer import Timer
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["NO_TRIGGER", "Trigger", "current_trigger"]

_LONGEST = 200
_MOST_READINGS = 20


class Trigger(Message):
    """The report, change, message or timer that led to a command.

    Attributes:
        kind: ``report``: a device reported values, or an event; ``device``: a device appeared, changed or went;
            ``message``: a raw message of a device; ``timer``: the time of a timer; empty where nothing is known, as for
            a wish of a person.
        id: The id of it: for a report and a device the ``sequence`` of the change, for a message its stream and time.
        device: The id of the device; empty where it is none.
        readings: What was reported.
        text: The raw message, what happened to the device, or the period of the timer, as text.
        at: When it happened; 0 where that is not known.
    """

    kind: Literal["", "report", "device", "message", "timer"] = ""
    id: str = ""
    device: str = ""
    readings: Annotated[tuple[Reading, ...], Field(max_length=_MOST_READINGS)] = ()
    text: str = ""
    at: Time = Time(sec=0, nanosec=0)


NO_TRIGGER = Trigger()


def current_trigger() -> Trigger:
    """Return what the task that calls this acts upon."""
    match CURRENT_CAUSE.get():
        case StateChange() as change:
            return _of_report(change)
        case DeviceChange() as change:
            return _of_device(change)
        case Timer() as timer:
            return Trigger(kind="timer", id=f"timer-{timer.period:g}", text=f"every {timer.period:g} s")
        case (str(device), RawMessage() as message):
            return _of_message(device, message)
    return NO_TRIGGER


def _of_report(change: StateChange) -> Trigger:
    return Trigger(
        kind="report",
        id=f"report-{change.sequence}",
        device=change.device,
        readings=change.readings[:_MOST_READINGS],
        at=change.told_at,
    )


def _of_device(change: DeviceChange) -> Trigger:
    device = change.device
    return Trigger(
        kind="device",
        id=f"device-{change.sequence}",
        device=device.id,
        text=f"{change.kind}: {change.why}"[:_LONGEST],
        at=device.last_seen,
    )


def _of_message(device: str, message: RawMessage) -> Trigger:
    text = message.payload[:_LONGEST].decode(errors="backslashreplace")
    return Trigger(
        kind="message",
        id=f"message-{message.gateway}-{message.key}-{message.received_at.to_seconds():.3f}",
        device=device,
        text=text,
        at=message.received_at,
    )
