"""Messages of ESPresense: each named device that its nodes hear is a tracker. Pure.

Source: ESPresense, ``BleFingerprint::fill`` (``id``, ``name``, ``mac``, ``rssi``, ``distance``) and ``fingerprint``
(``name:``), ``src/mqtt.cpp``.
"""

from typing import Final

from homebot.conventions.description import (
    AnnouncementEvent,
    AutoExpiry,
    Availability,
    DeviceAnnounced,
    LastWillAvailability,
)
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import JsonMessage, Readings, parse_object, text_of

_ROOT: Final = "espresense"
_SILENT_AFTER: Final = 120.0
"""Seconds; a node repeats an unchanged distance every few seconds, and a phone may sleep for a minute."""

_SELF_NAMED: Final = "name:"
"""Devices with the name that they give themselves by radio, which any passer-by can choose."""

_MAX_DEVICES: Final = 200
"""Further ones are left out, so that no flood pushes out the phones of the house."""

_MAX_ROOMS: Final = 50


class EspresenseReader:
    """Reader of the devices by the first message of each node that hears them.

    Attributes:
        rejected: The number of invalid messages.
    """

    def __init__(self) -> None:
        self.rejected = 0
        self._rooms: dict[str, tuple[str, tuple[str, ...]]] = {}

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the device, if it has a name and this node hears it for the first time.

        Raises:
            WireError: It is no JSON object.
        """
        _, _, device, room = topic.split("/")
        name, rooms = self._rooms.get(device, ("", ()))
        is_known = room in rooms or len(rooms) >= _MAX_ROOMS
        is_left_out = device.startswith(_SELF_NAMED) or (not rooms and len(self._rooms) >= _MAX_DEVICES)
        if is_known or is_left_out or retained or not (device and room and payload):
            return ()
        name = text_of(parse_object(payload).get("name")) or name
        if not name:
            return ()
        self._rooms[device] = name, (*rooms, room)
        return (_device(device, name, (*rooms, room)),)


def _device(device: str, name: str, rooms: tuple[str, ...]) -> DeviceAnnounced:
    topics = [f"{_ROOT}/devices/{device}/{room}" for room in rooms]
    part = JsonPart("", "x_tracker", tag="beacon")
    part.add_capability("place")
    part.add_expiry(AutoExpiry("place", _SILENT_AFTER))
    for topic in topics:
        part.read_from(topic, _read)
    wills = tuple(LastWillAvailability(f"{_ROOT}/rooms/{room}/status", b"online", b"offline") for room in rooms)
    return DeviceAnnounced(
        key=device,
        convention="espresense",
        identifiers=(),
        name=name,
        parts=(part.build(),),
        topic=topics[0],
        availability=Availability(wills, "any"),
        owns=tuple(topics),
        implies_alive=True,
        native=True,
        whole_device=True,
    )


def _read(_message: JsonMessage) -> Readings:
    return {"place": "home"}
