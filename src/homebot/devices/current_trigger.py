"""The trigger of the command that a task is giving, built from the cause that the task responds to."""

from homebot.devices.device import DeviceChange, StateChange
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.trigger import MAX_READINGS, NO_TRIGGER, Trigger
from homebot.graph.current_cause import CURRENT_CAUSE, CallCause, TimerCause
from homebot.graph.timer import Timer
from homebot.messages.builtin_interfaces import Time

_MAX_CHARACTERS = 200


def current_trigger() -> Trigger:
    """Return the trigger of the calling task."""
    match CURRENT_CAUSE.get():
        case None:
            return NO_TRIGGER
        case StateChange() as change:
            return Trigger(
                kind="report",
                id=f"report-{change.sequence}",
                device=change.device,
                readings=change.readings[:MAX_READINGS],
                at=change.told_at,
            )
        case DeviceChange() as change:
            device = change.device
            return Trigger(
                kind="device",
                id=f"device-{change.sequence}",
                device=device.id,
                text=f"{change.kind}: {change.why}"[:_MAX_CHARACTERS],
                at=device.last_seen,
            )
        case Timer() as timer:
            return Trigger(kind="timer", id=f"timer-{timer.period:g}", text=f"every {timer.period:g} s")
        case TimerCause() as job:
            return Trigger(
                kind="timer", id=job.id[:_MAX_CHARACTERS], text=job.text[:_MAX_CHARACTERS], at=Time.from_seconds(job.at)
            )
        case CallCause() as call:
            text = f"{call.issuer} called {call.service}"[:_MAX_CHARACTERS]
            return Trigger(kind="client", id=f"call-{call.at:.3f}", text=text, at=Time.from_seconds(call.at))
        case (str(device), RawMessage() as message):
            at = message.received_at
            text = message.payload[:_MAX_CHARACTERS].decode(errors="backslashreplace")
            return Trigger(
                kind="message",
                id=f"message-{message.gateway}-{message.key[:_MAX_CHARACTERS]}-{at.sec}.{at.nanosec // 1_000_000:03}",
                device=device,
                text=text,
                at=at,
            )
    return NO_TRIGGER
