"""Services of the runtime that load, unload and reload apps."""

from homebot.devices.value import ShortText
from homebot.messages.message import Message, ServiceType

__all__ = ["ChangeAppRequest", "ChangeAppResponse", "LoadApp", "ReloadApp", "UnloadApp"]


class ChangeAppRequest(Message):
    """An order for one app.

    Attributes:
        app: Its name; to load one, also the absolute path of its file, with ``:Class`` where that has several.
    """

    app: ShortText


class ChangeAppResponse(Message):
    """The answer.

    Attributes:
        success: Whether it was done.
        message: What was done, or why it was not.
    """

    success: bool = True
    message: str = ""


LoadApp = ServiceType("homebot/srv/LoadApp", ChangeAppRequest, ChangeAppResponse)
UnloadApp = ServiceType("homebot/srv/UnloadApp", ChangeAppRequest, ChangeAppResponse)
ReloadApp = ServiceType("homebot/srv/ReloadApp", ChangeAppRequest, ChangeAppResponse)
