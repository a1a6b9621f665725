"""Services of the runtime for apps and routines, and to reload the configuration."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType, UInt32

_NO_TIME = Time(sec=0, nanosec=0)


class AppJob(Message):
    """A job of an app.

    Attributes:
        text: When it is called, such as ``daily at 22:00``.
        next: When it is called next; 0 if unknown.
        running_since: When the running call began; 0 for none.
        dropped: Calls that were dropped because an earlier one was still running.
        note: Why it will not be called soon, such as ``no sunset today``.
    """

    name: str
    text: str
    next: Time = _NO_TIME
    running_since: Time = _NO_TIME
    dropped: UInt32 = 0
    note: str = ""


class AppInfo(Message):
    """An app.

    Attributes:
        state: ``running``, or the supervisor's word, such as ``given up``.
    """

    name: str
    state: str
    crashes: UInt32 = 0
    last_crash: str = ""
    jobs: tuple[AppJob, ...] = ()


class AppsRequest(Message):
    """Request for the apps."""


class AppsResponse(Message):
    """The apps.

    Attributes:
        apps: All apps, in the order of their start.
        zone: The IANA name of the home's time zone; empty if it has none.
    """

    apps: tuple[AppInfo, ...] = ()
    zone: ShortText = ""


class ChangeAppRequest(Message):
    """Request to change one app.

    Attributes:
        app: Its name; to load it, or the absolute path of its file, with ``:Class`` if that has several.
    """

    app: ShortText


class ChangeAppResponse(Message):
    """The answer.

    Attributes:
        message: The change, or why there was none.
    """

    success: bool = True
    message: str = ""


RoutineChange: TypeAlias = Literal["run", "enable", "disable", "new", "edit", "remove"]

_Texts: TypeAlias = Annotated[tuple[ShortText, ...], Field(max_length=50)]


class RoutineNote(Message):
    """The result of a start of a routine, or why it did not run."""

    at: Time
    text: str


class RoutineInfo(Message):
    """A routine, with its texts as they are configured.

    Attributes:
        app: The name of its node, which issues its commands.
        steps: Its steps; a choice is one text.
        next: When a time starts it next; 0 if none does.
        notes: The last ten notes, oldest first.
        text: Its table in TOML.
        is_kept: Whether services may edit and remove it; others are in the configuration.
        proposed_by: The client that proposed it; it does not start until it is enabled. Empty for the owner's.
        of_habit: Whether it was made of a habit that homebot found.
        problem: Why it does not run at all; empty if it does.
        hints: Names, values and meetings with others for which it cannot work now, with suggestions; only if asked for.
        act: Queries for the devices that it may command; empty by default: all that do not always ask.
        lacks: Those that it lacks for its steps, only if asked for.
    """

    name: str
    app: str
    when: _Texts = ()
    conditions: _Texts = ()
    steps: Annotated[tuple[str, ...], Field(max_length=50)] = ()
    mode: str = ""
    enabled: bool = True
    is_running: bool = False
    next: Time = _NO_TIME
    notes: tuple[RoutineNote, ...] = ()
    text: str = ""
    is_kept: bool = False
    proposed_by: str = ""
    of_habit: bool = False
    problem: str = ""
    hints: tuple[str, ...] = ()
    act: tuple[str, ...] = ()
    lacks: tuple[str, ...] = ()


class RoutinesRequest(Message):
    """Request for the routines.

    Attributes:
        check: Whether to compare them with the devices of the house, and with each other.
        device: Only those that command the device with this id; empty for all.
    """

    check: bool = False
    device: ShortText = ""


class RoutinesResponse(Message):
    """The routines.

    Attributes:
        zone: The IANA name of the home's time zone; empty if it has none.
    """

    routines: tuple[RoutineInfo, ...] = ()
    zone: ShortText = ""


class HomePlaceRequest(Message):
    """Request for the place of the home, for trials with the sun."""


class HomePlaceResponse(Message):
    """The place of the home.

    Attributes:
        place: Its latitude and longitude to a tenth of a degree; empty if unknown.
    """

    place: Annotated[tuple[float, ...], Field(max_length=2)] = ()


class ChangeRoutineRequest(Message):
    """Request to start a routine now, without its conditions, to switch it on or off, or to write it.

    Attributes:
        name: Its name, or that of its node; not used for ``new``.
        text: For ``new`` and ``edit``: its table ``[[routines]]`` in TOML; for ``new`` it may be several, for ``edit``
            empty for the one that is kept.
        act: Queries for further devices that it may command, for its key ``act``.
        unless_asks: Whether to do nothing if a person must agree first, as ``asks`` of the answer says.
        of_habit: Whether a new one is made of a habit that homebot found.
        issuer: The client that asks; set by the door.
    """

    name: ShortText = ""
    change: RoutineChange
    text: Annotated[str, Field(max_length=60_000)] = ""
    act: _Texts = ()
    unless_asks: bool = False
    of_habit: bool = False
    issuer: str = ""


class ChangeRoutineResponse(Message):
    """The answer.

    Attributes:
        message: The change, or why there was none.
        asks: The reasons for ``unless_asks`` to do nothing: the parts that always ask, each with the
            reason, or the devices that it may command from then on.
    """

    success: bool = True
    message: str = ""
    asks: tuple[KeyValue, ...] = ()


class ProposeRoutineRequest(Message):
    """Request to keep a routine that does not start until the owner enables it.

    Attributes:
        text: Its table ``[[routines]]`` in TOML.
        issuer: The client that proposes it; set by the door.
    """

    text: Annotated[str, Field(max_length=60_000)]
    issuer: str = ""


class ReloadRequest(Message):
    """Request to reload the configuration.

    Attributes:
        allow_removal: Whether tables, tokens, rights, policies and places may be missing that are in force.
    """

    allow_removal: bool = False


LoadApp = ServiceType("homebot/srv/LoadApp", ChangeAppRequest, ChangeAppResponse)
UnloadApp = ServiceType("homebot/srv/UnloadApp", ChangeAppRequest, ChangeAppResponse)
ReloadApp = ServiceType("homebot/srv/ReloadApp", ChangeAppRequest, ChangeAppResponse)
ListApps = ServiceType("homebot/srv/ListApps", AppsRequest, AppsResponse)
GetHomePlace = ServiceType("homebot/srv/GetHomePlace", HomePlaceRequest, HomePlaceResponse)
ListRoutines = ServiceType("homebot/srv/ListRoutines", RoutinesRequest, RoutinesResponse)
ChangeRoutine = ServiceType("homebot/srv/ChangeRoutine", ChangeRoutineRequest, ChangeRoutineResponse)
ProposeRoutine = ServiceType("homebot/srv/ProposeRoutine", ProposeRoutineRequest, ChangeRoutineResponse)
Reload = ServiceType("homebot/srv/Reload", ReloadRequest, ChangeAppResponse)
