"""Kinds of openings with a contact, cover or lock: doors, windows, garage doors, gates. Pure.

The owner says it by a tag; otherwise the class in an announcement does, then the names, then the model.
"""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.devices.always_ask import models_of
from homebot.devices.device import Device
from homebot.devices.words import GARAGE, matching_words
from homebot.support.folding import fold

_TYPES: Final = frozenset({"closure", "contact_sensor", "door_lock", "window_covering"})
_BY_CLASS: Final[Mapping[str, str]] = MappingProxyType(
    {"door": "door", "garage": "garage_door", "garage_door": "garage_door", "gate": "gate", "window": "window"}
    | {kind: kind for kind in ("awning", "blind", "curtain", "shade", "shutter")}
)
_BY_WORDS: Final[Mapping[str, re.Pattern[str]]] = MappingProxyType(
    {
        "garage_door": re.compile(
            r"garage ?(?:doors?|deur|poort|port)|garagen?(?:tor|tue?r)|porte (?:de |du )?garage"
            r"|puerta (?:de |del )?garaje|porta (?:del )?garage|brama garazowa"
        ),
        "gate": re.compile(
            r"\bgates?\b|\b(?:garten|hof|einfahrts?|schiebe|roll|zufahrts)?tore?\b|pforte|portail|portillon|portone"
            r"|\bporton|cancell[oi]|cancela|poort|\bhek\b|brama|furtka"
        ),
        "window": re.compile(r"window|skylight|fenster|fenetre|ventana|finestra|\braam|raam\b|\bokn[oa]\b"),
        "door": re.compile(
            r"doors?\b|\bdoor|\btue?r|(?<!tempera)tue?r(?:en)?\b|tue?r(?:kontakt|sensor|schloss)|\bport[ae]s?\b|puerta"
            r"|deur|drzwi"
        ),
    }
)
"""The kinds by the words that say them, the narrowest first, in the languages of the page and Polish."""


def opening_kind(device: Device) -> str:
    """Return ``door``, ``window``, ``garage_door`` or ``gate``, or the class of a cover such as ``blind``.

    Empty if nothing says it, or *device* is no contact, cover or lock.
    """
    parts = [part.part for part in device.parts if part.part.service_type in _TYPES and not part.part.category]
    if not parts:
        return ""
    stated = [fold(tag).replace(" ", "_") for tag in device.tags] + [part.tag for part in parts]
    if kind := next((_BY_CLASS[word] for word in stated if word in _BY_CLASS), ""):
        return kind
    for name in map(fold, (*(part.name for part in parts), device.name, *device.names)):
        if kinds := _kinds_in(name):
            return kinds[0]
        if matching_words(name, GARAGE):
            return "garage_door"
    for model in map(fold, models_of(device)):
        if len(kinds := _kinds_in(model)) == 1:  # else it is made for doors and windows
            return kinds[0]
    return ""


def _kinds_in(text: str) -> list[str]:
    return [kind for kind, words in _BY_WORDS.items() if words.search(text)]
