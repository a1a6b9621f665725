"""Services of the runtime that list, load, unload and reload apps."""

from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceType, UInt32

__all__ = [
    "AppInfo",
    "AppJob",
    "AppsRequest",
    "AppsResponse",
    "ChangeAppRequest",
    "ChangeAppResponse",
    "ListApps",
    "LoadApp",
    "ReloadApp",
    "UnloadApp",
]

_NO_TIME = Time(sec=0, nanosec=0)


class AppJob(Message):
    """A job of an app.

    Attributes:
        text: When it is called, such as ``daily at 22:00``.
        next: When that is next; 0 where it is not known.
        running_since: When a call that is at work began; 0 for none.
        dropped: Calls that were dropped because an earlier one was at work.
        note: Why it is not called soon, such as ``no sunset today``.
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
        state: ``running``, or as the supervisor says, such as ``given up``.
    """

    name: str
    state: str
    crashes: UInt32 = 0
    last_crash: str = ""
    jobs: tuple[AppJob, ...] = ()


class AppsRequest(Message):
    """A question for the apps."""


class AppsResponse(Message):
    """The apps.

    Attributes:
        apps: Each, in the order of their start.
        zone: The IANA name of the home's time zone; empty where that has none.
    """

    apps: tuple[AppInfo, ...] = ()
    zone: ShortText = ""


class ChangeAppRequest(Message):
    """An order for one app.

    Attributes:
        app: Its name; to load one, also the absolute path of its file, with ``:Class`` where that has several.
    """

    app: ShortText


class ChangeAppResponse(Message):
    """The answer.

    Attributes:
        message: What was done, or why it was not.
    """

    success: bool = True
    message: str = ""


LoadApp = ServiceType("homebot/srv/LoadApp", ChangeAppRequest, ChangeAppResponse)
UnloadApp = ServiceType("homebot/srv/UnloadApp", ChangeAppRequest, ChangeAppResponse)
ReloadApp = ServiceType("homebot/srv/ReloadApp", ChangeAppRequest, ChangeAppResponse)
ListApps = ServiceType("homebot/srv/ListApps", AppsRequest, AppsResponse)
