"""The trigger of a command: a report, a change of a device, a raw message or a timer, with its facts."""

from typing import Annotated, Literal

from pydantic import Field

from homebot.devices.value import Reading, ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

MAX_READINGS = 20


class Trigger(Message):
    """The report, change, message, timer or call that led to a command.

    Attributes:
        kind: ``report``: a device reported values, or an event; ``device``: a device appeared, changed or disappeared;
        ``message``: a raw message of a device; ``timer``: a timer was due; ``lease``: the part is held; ``client``: a
        client called a service of the issuer; ``goal``: a plan for a goal needs it; ``end``: the part
        is put back after an identification; ``program``: a client of the HTTP API, or without a token, gave it itself;
        empty if unknown, as for a person's command.
        id: Its id: for a report and a device the ``sequence`` of the change, for a message its stream and time.
        device: The id of the device; empty without one.
        text: The raw message, the change of the device, the period of the timer, the holder of the part or the call, as
                text.
        at: The time of the cause; 0 if unknown.
        scene: The name of the scene that was applied, or undone, because of it; empty for none.
        is_undo: Whether the scene was undone.
    """

    kind: Literal["", "lease", "report", "device", "message", "timer", "client", "goal", "end", "program"] = ""
    id: ShortText = ""
    device: ShortText = ""
    readings: Annotated[tuple[Reading, ...], Field(max_length=MAX_READINGS)] = ()
    text: ShortText = ""
    at: Time = Time(sec=0, nanosec=0)
    scene: ShortText = ""
    is_undo: bool = False


NO_TRIGGER = Trigger()
