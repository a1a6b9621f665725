"""Services with which the owner states the rooms and names of devices."""

from typing import Annotated

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

_MAX_CHARACTERS = 800_000


class PlaceDeviceRequest(Message):
    """State the room of a device; the directory remembers it across restarts.

    Attributes:
        device: The id of the device; for an absent device, its name or a hardware address is possible too.
        room: The room, or a floor; empty to withdraw a statement of this service or an import.
        is_new: Whether a new room may have a name that is one typo away from another's.
        may_be_absent: Whether the device may be absent: it is placed when it appears.
        at: Its position in metres, ``X,Y[,FLOOR][ ±ERROR m]``; empty for none. Without a room it is in the room at that
            position.
    """

    device: str
    room: str = ""
    is_new: bool = False
    may_be_absent: bool = False
    at: str = ""


class PlaceDeviceResponse(ServiceAnswer):
    """The result of placing a device.

    Attributes:
        room: The room of the device, now or when it appears; empty for none.
        absent: The id or hardware address by which an absent device will be recognised; empty for a present one.
    """

    room: str = ""
    absent: str = ""


class AliasDeviceRequest(Message):
    """Give a device another name, which is shown from now on; the directory remembers it across restarts.

    Attributes:
        remove: Whether to remove the name instead.
    """

    device: str
    alias: str
    remove: bool = False


class AliasDeviceResponse(ServiceAnswer):
    """The result of naming a device.

    Attributes:
        aliases: All names that the owner gave it, the displayed one first.
    """

    aliases: tuple[str, ...] = ()


class TagDeviceRequest(Message):
    """Tag a device with a word by which it is found; the directory remembers it across restarts.

    Attributes:
        remove: Whether to remove the tag instead.
    """

    device: str
    tag: str
    remove: bool = False


class TagDeviceResponse(ServiceAnswer):
    """The result of tagging a device."""

    tags: tuple[str, ...] = ()


class GetPlacesRequest(Message):
    """Request for the rooms of the house."""


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
        floor: Its floor; empty if none is stated.
        doors: The rooms to which a door connects it.
        areas: Its area; empty if unknown.
    """

    name: str
    floor: str = ""
    doors: tuple[str, ...] = ()
    areas: tuple[AreaRing, ...] = ()


class DoorInfo(Message):
    """A door, an opening, or a stair, between two rooms.

    Attributes:
        x: The coordinates of its two ends, or of its centre, in metres; empty if unknown.
        y: As for *x*.
        width: Metres; only with a centre.
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
        home: The name of the home, which contains all rooms.
        absent: The rooms of absent devices, by id or hardware address; at most 1,000.
    """

    home: str
    rooms: tuple[RoomInfo, ...] = ()
    doors: tuple[DoorInfo, ...] = ()
    absent: tuple[KeyValue, ...] = ()


class TeachPlaceRequest(Message):
    """The place of a device according to a tag on it or a robot; it counts if neither owner nor device states one.

    Attributes:
        tag: The key of the tag; empty for a code.
        room: The room that the tag or code states; the room of the tag itself, if known, takes precedence.
        at: The position at which a robot saw it, as for :class:`PlaceDeviceRequest`, instead of a tag.
    """

    device: str
    gateway: str
    tag: str = ""
    room: str = ""
    at: str = ""


class TeachPlaceResponse(ServiceAnswer):
    """The result of teaching a room.

    Attributes:
        is_new: Whether the tag stated another room before, or none.
    """

    room: str = ""
    is_new: bool = False


class ChangeRoomRequest(Message):
    """Request to rename or remove an imported room, or to rename one in which devices were placed.

    Attributes:
        name: Its new name; empty to remove it.
    """

    room: str
    name: str = ""


class ChangeRoomResponse(ServiceAnswer):
    """The result of changing a room."""

    name: str = ""


class ExportPlacesRequest(Message):
    """Request for all rooms and all the owner's facts about devices, as the text of a places file."""


class ExportPlacesResponse(Message):
    """A places file: a table ``[places]`` in TOML."""

    text: str


class ImportPlacesRequest(Message):
    """Import a places file: all of it or, if it has a mistake, nothing. Facts that it leaves out stay.

    Attributes:
        replaces: Whether its room for a device replaces one that was stated here before.
        source: The robot whose map the room areas come from; empty for the owner.
    """

    text: Annotated[str, Field(max_length=_MAX_CHARACTERS)]
    replaces: bool = False
    source: str = ""


class ImportPlacesResponse(ServiceAnswer):
    """The result of an import; the message names key and value of the first mistake.

    Attributes:
        added: New rooms, and devices with new facts, as text.
        kept: Rooms of devices that were kept although the file has others, as text.
    """

    added: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()


class OwnerRequest(Message):
    """Request of the owner to the directory: a statement or decision about devices or rooms.

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
