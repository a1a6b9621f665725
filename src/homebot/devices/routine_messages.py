"""Services of the runtime that list routines, start them, and switch them on and off."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType

__all__ = [
    "ChangeRoutine",
    "ChangeRoutineRequest",
    "ChangeRoutineResponse",
    "ListRoutines",
    "RoutineChange",
    "RoutineInfo",
    "RoutineNote",
    "RoutinesRequest",
    "RoutinesResponse",
]

RoutineChange: TypeAlias = Literal["run", "enable", "disable"]

_Texts: TypeAlias = Annotated[tuple[ShortText, ...], Field(max_length=50)]


class RoutineNote(Message):
    """What happened when it was started, or why it did not run."""

    at: Time
    text: str


class RoutineInfo(Message):
    """A routine, with its texts as they are configured.

    Attributes:
        app: The name of its node, which issues its commands.
        next: When a time starts it next; 0 if none does.
        notes: The last ten notes, oldest first.
    """

    name: str
    app: str
    when: _Texts = ()
    conditions: _Texts = ()
    steps: _Texts = ()
    mode: str = ""
    enabled: bool = True
    is_running: bool = False
    next: Time = Time(sec=0, nanosec=0)
    notes: tuple[RoutineNote, ...] = ()


class RoutinesRequest(Message):
    """Request for the routines."""


class RoutinesResponse(Message):
    """The routines.

    Attributes:
        zone: The IANA name of the home's time zone; empty if it has none.
    """

    routines: tuple[RoutineInfo, ...] = ()
    zone: ShortText = ""


class ChangeRoutineRequest(Message):
    """Request to start a routine now, whatever its conditions, or to switch it on or off until the next change.

    Attributes:
        name: Its name, or that of its node.
    """

    name: ShortText
    change: RoutineChange


class ChangeRoutineResponse(Message):
    """The answer.

    Attributes:
        message: What was done, or why it was not.
    """

    success: bool = True
    message: str = ""


ListRoutines = ServiceType("homebot/srv/ListRoutines", RoutinesRequest, RoutinesResponse)
ChangeRoutine = ServiceType("homebot/srv/ChangeRoutine", ChangeRoutineRequest, ChangeRoutineResponse)
