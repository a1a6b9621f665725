"""The services by which the owner states the rooms and names of devices."""

from typing import Annotated

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

__all__ = [
    "AliasDevice",
    "AreaRing",
    "ChangeRoom",
    "DoorInfo",
    "ExportPlaces",
    "GetPlaces",
    "ImportPlaces",
    "OwnerRequest",
    "PlaceDevice",
    "RoomInfo",
    "TagDevice",
    "TeachPlace",
]


_LONGEST = 800_000


class PlaceDeviceRequest(Message):
    """State the room that a device is in; the directory remembers that over a restart.

    Attributes:
        device: The id of the device; of one that is not there yet also its name or a hardware address.
        room: The room, or a floor; empty to take back a statement of this service or an import.
        is_new: Whether it may be a room with a name one typo away from that of another.
        may_be_absent: Whether the device need not be there yet: it is placed when it appears.
        at: Its position in metres, ``X,Y[,FLOOR][ ±ERROR m]``; empty for none. Without a room it is in the one that is
            there.
    """

    device: str
    room: str = ""
    is_new: bool = False
    may_be_absent: bool = False
    at: str = ""


class PlaceDeviceResponse(ServiceAnswer):
    """The result of placing a device.

    Attributes:
        room: The room that the device is in now, or will be; empty for none.
        absent: The id or hardware address by which a device that is not there yet will be known; empty for one that is.
    """

    room: str = ""
    absent: str = ""


class AliasDeviceRequest(Message):
    """Give a device a further name, which is shown from now on; the directory remembers that over a restart.

    Attributes:
        remove: Whether to take it back instead.
    """

    device: str
    alias: str
    remove: bool = False


class AliasDeviceResponse(ServiceAnswer):
    """The result of naming a device.

    Attributes:
        aliases: All names that the owner gave it, the one that is shown first.
    """

    aliases: tuple[str, ...] = ()


class TagDeviceRequest(Message):
    """Tag a device with a word by which it is found; the directory remembers that over a restart.

    Attributes:
        remove: Whether to take it back instead.
    """

    device: str
    tag: str
    remove: bool = False


class TagDeviceResponse(ServiceAnswer):
    """The result of tagging a device."""

    tags: tuple[str, ...] = ()


class GetPlacesRequest(Message):
    """A question for the rooms of the house."""


class AreaRing(Message):
    """The corners of an area, or of a hole in the area before it.

    Attributes:
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    is_hole: bool = False


class RoomInfo(Message):
    """A room.

    Attributes:
        floor: The floor that it is on; empty if none is stated.
        doors: The rooms that a door joins it to.
        areas: Its area; empty if that is not known.
    """

    name: str
    floor: str = ""
    doors: tuple[str, ...] = ()
    areas: tuple[AreaRing, ...] = ()


class DoorInfo(Message):
    """A door, an opening, or a stair, between two rooms.

    Attributes:
        x: Metres of its two ends, or of its centre; empty if that is not known.
        y: Likewise.
        width: Metres; only for a centre.
        contact: The device that reports whether it is open; empty for none.
        lock: The device that locks it; empty for none.
    """

    name: str
    rooms: tuple[str, ...]
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()
    width: float = 0.8
    contact: str = ""
    lock: str = ""


class GetPlacesResponse(Message):
    """The rooms of the house, as the owner states them.

    Attributes:
        home: The name of the home, in which all rooms are.
        absent: The rooms of devices that are not there, by their ids or hardware addresses; at most 1,000.
    """

    home: str
    rooms: tuple[RoomInfo, ...] = ()
    doors: tuple[DoorInfo, ...] = ()
    absent: tuple[KeyValue, ...] = ()


class TeachPlaceRequest(Message):
    """The room of a device, as a tag says that is at it; it counts where neither the owner nor the device says one.

    Attributes:
        tag: The key of the tag; empty for a code.
        room: The room that the tag or code says; the one that the tag is in, as far as that is known, counts more.
    """

    device: str
    gateway: str
    tag: str = ""
    room: str = ""


class TeachPlaceResponse(ServiceAnswer):
    """The result of teaching a room.

    Attributes:
        is_new: Whether the tag taught another room before, or none.
    """

    room: str = ""
    is_new: bool = False


class ChangeRoomRequest(Message):
    """An order to rename or remove a room that was imported, or to rename one in which devices were placed.

    Attributes:
        name: Its new name; empty to remove it.
    """

    room: str
    name: str = ""


class ChangeRoomResponse(ServiceAnswer):
    """The result of changing a room."""

    name: str = ""


class ExportPlacesRequest(Message):
    """A request for all rooms and all that the owner states of devices, as the text of a places file."""


class ExportPlacesResponse(Message):
    """A places file: a table ``[places]`` in TOML."""

    text: str


class ImportPlacesRequest(Message):
    """Take over a places file: all of it or, with a mistake in it, nothing. Facts that it leaves out stay.

    Attributes:
        replaces: Whether its room of a device wins over one that was stated here before.
        source: The robot whose map the areas of its rooms are from; empty for the owner's word.
    """

    text: Annotated[str, Field(max_length=_LONGEST)]
    replaces: bool = False
    source: str = ""


class ImportPlacesResponse(ServiceAnswer):
    """The result of an import; the message names key and value of the first mistake.

    Attributes:
        added: Rooms, and devices of which something is new, as text.
        kept: Rooms of devices that stayed although the file has others, as text.
    """

    added: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()


class OwnerRequest(Message):
    """A request to the directory that states something of devices or rooms, or decides on them.

    Attributes:
        service: The name of the service, one of the services of the owner.
        request: The request, as the text of a JSON object.
    """

    at: Time
    service: str
    request: str


PlaceDevice = ServiceType("homebot/srv/PlaceDevice", PlaceDeviceRequest, PlaceDeviceResponse)
AliasDevice = ServiceType("homebot/srv/AliasDevice", AliasDeviceRequest, AliasDeviceResponse)
TagDevice = ServiceType("homebot/srv/TagDevice", TagDeviceRequest, TagDeviceResponse)
GetPlaces = ServiceType("homebot/srv/GetPlaces", GetPlacesRequest, GetPlacesResponse)
TeachPlace = ServiceType("homebot/srv/TeachPlace", TeachPlaceRequest, TeachPlaceResponse)
ChangeRoom = ServiceType("homebot/srv/ChangeRoom", ChangeRoomRequest, ChangeRoomResponse)
ExportPlaces = ServiceType("homebot/srv/ExportPlaces", ExportPlacesRequest, ExportPlacesResponse)
ImportPlaces = ServiceType("homebot/srv/ImportPlaces", ImportPlacesRequest, ImportPlacesResponse)
