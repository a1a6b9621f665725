"""Messages of OwnTracks: each phone is a tracker. Pure.

Source: owntracks.org/booklet/tech/json, ``_type=location`` and ``_type=transition``.
"""

from typing import Final

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, parse_object, percent_of, text_of
from homebot.support.folding import fold

__all__ = ["OwnTracksReader"]

_MOST_NAMED: Final = 20


class OwnTracksReader:
    """Reader of the locations of phones.

    Attributes:
        rejected: The number of invalid messages.
    """

    def __init__(self, prefix: str) -> None:
        self.rejected = 0
        self._prefix = prefix
        self._encrypted: dict[str, None] = {}

    def problems(self) -> tuple[str, ...]:
        """Return the phones that encrypt."""
        return tuple(f"{one} is encrypted; remove the key in the app, and use TLS" for one in self._encrypted)

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
        if kind == "encrypted" and len(self._encrypted) < _MOST_NAMED:
            self._encrypted[topic] = None
        return (_phone(topic, user, device),) if kind == "location" else ()


def _phone(topic: str, user: str, device: str) -> DeviceAnnounced:
    part = JsonPart("", "x_tracker", tag="gps")
    part.add_capability("place")
    part.add_capability("battery")
    part.read_from(topic, _read_location)
    part.read_from(f"{topic}/event", _read_transition)
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
    )


def _read_location(message: JsonMessage) -> Readings:
    if message.get("_type") != "location":
        return NO_READINGS
    found: dict[str, str | float | None] = {}
    if (charge := percent_of(message.get("batt"))) is not None:
        found["battery"] = charge
    regions = message.get("inregions")
    if isinstance(regions, list):
        names = [name for one in regions if (name := text_of(one))]
        found["place"] = "home" if any(map(_is_home, names)) else names[0] if names else "not_home"
    return found


def _read_transition(message: JsonMessage) -> Readings:
    """Read the region of the home alone: another one may overlap with it."""
    event = message.get("event")
    if message.get("_type") != "transition" or event not in {"enter", "leave"} or not _is_home(message.get("desc")):
        return NO_READINGS
    return {"place": "home" if event == "enter" else "not_home"}


def _is_home(name: object) -> bool:
    return isinstance(name, str) and fold(name) == "home"
