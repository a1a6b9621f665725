"""Messages about the order of the page, and the use of devices."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.value import ShortText
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

LayoutList: TypeAlias = Literal["favorites", "hidden", "not_here", "rooms"]


class PageLayout(Message):
    """The order of the owner, which each screen shows: ids of devices, and rooms by their names.

    Attributes:
        favorites: Devices that stand first, in their order.
        hidden: Devices, and rooms as ``room:NAME``, that are not shown until asked for.
        not_here: Devices that are never proposed as favorites.
        rooms: The first rooms, in their order; all others come after them.
        icons: Chosen icons, by the id of a device or ``room:NAME``.
        undoes: The last change in words, which an undo takes back; empty for none.
    """

    favorites: tuple[str, ...] = ()
    hidden: tuple[str, ...] = ()
    not_here: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    icons: tuple[KeyValue, ...] = ()
    undoes: str = ""


class ChangeLayoutRequest(Message):
    """A change of the layout.

    Attributes:
        change: ``add`` puts *names* at the end of *list*, unless they are in it; ``remove`` takes them out; ``order``
            puts them first, in their order, without removing others; ``icon`` gives them *icon*, none if it is empty;
            ``undo`` takes the last change back, and an undo itself.
        issuer: The client that asks; set by the door.
    """

    change: Literal["add", "remove", "order", "icon", "undo"]
    list: LayoutList = "favorites"
    names: Annotated[tuple[ShortText, ...], Field(max_length=500)] = ()
    icon: ShortText = ""
    issuer: str = ""


class ChangeLayoutResponse(ServiceAnswer):
    """The layout after the change."""

    layout: PageLayout = PageLayout()


class DeviceUsage(Message):
    """The commands of people to a device.

    Attributes:
        hours: Their number in each hour of the day, from midnight, in 28 days.
    """

    device: str
    hours: tuple[UInt32, ...]


class UsageRequest(Message):
    """Request for the use of devices."""


class UsageResponse(Message):
    """The devices that people command, the most used first; neither routines, scenes nor programs count.

    Attributes:
        lost: The number of commands today that were not counted, as there were too many devices.
    """

    devices: tuple[DeviceUsage, ...] = ()
    lost: UInt32 = 0


class PictureNamesRequest(Message):
    """Request for the pictures at addresses of the owner."""


class PictureNamesResponse(ServiceAnswer):
    """Their names: of devices, or of cameras without one."""

    names: tuple[str, ...] = ()


ChangeLayout = ServiceType("homebot/srv/ChangeLayout", ChangeLayoutRequest, ChangeLayoutResponse)
GetUsage = ServiceType("homebot/srv/GetUsage", UsageRequest, UsageResponse)
ListPictures = ServiceType("homebot/srv/ListPictures", PictureNamesRequest, PictureNamesResponse)
