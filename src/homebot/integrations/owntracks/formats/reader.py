"""Messages of OwnTracks: each phone is a tracker. Pure.

Source: owntracks.org/booklet/tech/json, ``_type=location`` and ``_type=transition``; both apps leave ``inregions`` out
of a location in no region (owntracks/ios issue 670; owntracks/android, ``MessageLocation.kt``).
"""

from typing import Final

from homebot.conventions.description import TRACKER_SILENCE, AnnouncementEvent, DeviceAnnounced
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import (
    NO_READINGS,
    JsonMessage,
    Readings,
    number_of,
    parse_object,
    percent_of,
    text_of,
)
from homebot.conventions.table_codec import Reader
from homebot.support.bounded_map import BoundedMap
from homebot.support.folding import fold

_MAX_NAMED: Final = 20
_MAX_PHONES: Final = 200

_LATE: Final = 7 * 86_400.0
"""Seconds; the app for Android tries for a week to send a message. Older ones are those of a clock that was set."""


class OwnTracksReader:
    """Reader of the locations of phones.

    Attributes:
        rejected: The number of invalid messages.
    """

    def __init__(self, prefix: str) -> None:
        self.rejected = 0
        self._prefix = prefix
        self._encrypted: dict[str, None] = {}
        self._phones: BoundedMap[str, DeviceAnnounced] = BoundedMap(_MAX_PHONES)

    def problems(self) -> tuple[str, ...]:
        """Return the phones that encrypt."""
        return tuple(f"{phone} is encrypted; remove the key in the app, and use TLS" for phone in self._encrypted)

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the phone that told its location; none for any other message.

        Raises:
            WireError: It is no JSON object.
        """
        del retained
        user, _, device = topic.removeprefix(f"{self._prefix}/").partition("/")
        if not (user and device and payload):
            return ()
        kind = parse_object(payload).get("_type")
        if kind == "encrypted" and len(self._encrypted) < _MAX_NAMED:
            self._encrypted[topic] = None
        if kind != "location":
            return ()
        self._encrypted.pop(topic, None)
        self._phones[topic] = phone = self._phones.get(topic) or _phone(topic, user, device)
        return (phone,)


class _Order:
    """The order of the messages of a phone, by their times: some come late, from its queue or from the broker."""

    def __init__(self) -> None:
        self._newest = 0.0

    def of(self, read: Reader[JsonMessage]) -> Reader[JsonMessage]:
        """Return *read* for the messages about a place that are not late, and for all others."""

        def read_in_order(message: JsonMessage) -> Readings:
            readings, told_at = read(message), number_of(message.get("tst"))
            if "place" not in readings or told_at is None:
                return readings
            if 0 < self._newest - told_at <= _LATE:
                return NO_READINGS
            self._newest = told_at
            return readings

        return read_in_order


def _phone(topic: str, user: str, device: str) -> DeviceAnnounced:
    part, order = JsonPart("", "x_tracker", tag="gps"), _Order()
    part.add_capability("place")
    part.add_capability("battery")
    part.read_from(topic, order.of(_read_location))
    part.read_from(f"{topic}/event", order.of(_read_transition))
    return DeviceAnnounced(
        key=f"{user}/{device}",
        convention="owntracks",
        identifiers=(),
        name=text_of(f"{user} {device}"),
        parts=(part.build(),),
        topic=topic,
        owns=(topic,),
        implies_alive=True,
        native=True,
        whole_device=True,
        stale_after=TRACKER_SILENCE,
    )


def _read_location(message: JsonMessage) -> Readings:
    if message.get("_type") != "location":
        return NO_READINGS
    readings: dict[str, str | float | None] = {}
    if (charge := percent_of(message.get("batt"))) is not None:
        readings["battery"] = charge
    regions = message.get("inregions", [])
    if isinstance(regions, list):
        names = [name for region in regions if (name := text_of(region))]
        readings["place"] = "home" if any(map(_is_home, names)) else names[0] if names else "not_home"
    return readings


def _read_transition(message: JsonMessage) -> Readings:
    """Read the region of the home alone: another one may overlap with it."""
    event = message.get("event")
    if message.get("_type") != "transition" or event not in {"enter", "leave"} or not _is_home(message.get("desc")):
        return NO_READINGS
    return {"place": "home" if event == "enter" else "not_home"}


def _is_home(name: object) -> bool:
    return isinstance(name, str) and fold(name) == "home"
