"""Parts of configs that differ in nothing but names and topics: one is built, the others are made after it. Pure.

A large house has five times as many configs as shapes of them: one shape for the batteries of all devices, and so on.
"""

import re
from collections.abc import Callable
from typing import NamedTuple

from pydantic_core import to_json

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import is_movable, moved
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.support.bounded_map import BoundedMap

SHAPED = frozenset({"binary_sensor", "button", "light", "number", "select", "sensor", "switch", "text"})
"""Components that many devices have alike."""

_OWN = frozenset(
    {
        *("availability", "availability_mode", "availability_template", "payload_available", "payload_not_available"),
        *("default_entity_id", "device", "name", "object_id", "origin", "unique_id"),
    }
)
"""Fields that are no part of a shape: the identity, and the availability, which is read apart from the part."""

_PLAIN_TOPIC = re.compile("[^+#$\x00-\x1f\x7f-\x9f\ufdd0-\ufdef\ufffe\uffff]{1,255}").fullmatch
_MAX_SHAPES = 1000
_MAX_SHAPE_CHARACTERS = 2048


class _Shape(NamedTuple):
    """The part of a config that equal parts share.

    Attributes:
        topics: The fields with topics.
        places: Of each topic, the place of the first that is the same.
        others: All other fields, in JSON.
    """

    component: str
    is_secret: bool
    topics: tuple[str, ...]
    places: tuple[int, ...]
    others: bytes


class PartShapes:
    """The last thousand shapes of parts, each with the first part and its topics."""

    def __init__(self) -> None:
        self._known: BoundedMap[_Shape, tuple[DescribedPart, list[str]]] = BoundedMap(_MAX_SHAPES)

    def part(self, config: DiscoveryConfig, build: Callable[[DiscoveryConfig], DescribedPart]) -> DescribedPart:
        """Return the part that *build* makes of *config*.

        Raises:
            WireError: The config is invalid.
        """
        topics: list[str] = []
        shape = _shape_of(config, topics)
        if shape is None:
            return build(config)
        known = self._known.get(shape)
        if known is not None:
            first, its_topics = known
            own = dict(zip(its_topics, topics, strict=True))
            return moved(first, own, part_id=config.part_id, name=config.clean_text("name"))
        described = build(config)
        if is_movable(described, topics):
            self._known[shape] = described, topics
        return described


def _shape_of(config: DiscoveryConfig, topics: list[str]) -> _Shape | None:
    """Return the shape of *config*, its topics added to *topics*; None for an unusual one."""
    values = config.values
    if config.component not in SHAPED or not isinstance(values.get("name", ""), (str, type(None))):
        return None
    names, places, others = [], [], {}
    for key, value in values.items():
        if key.endswith("topic"):
            if not isinstance(value, str) or not _PLAIN_TOPIC(value):
                return None
            names.append(key)
            topics.append(value)
            places.append(topics.index(value))
        elif key not in _OWN:
            others[key] = value
    text = to_json(others)
    if len(text) > _MAX_SHAPE_CHARACTERS:
        return None
    return _Shape(config.component, config.is_secret, tuple(names), tuple(places), text)
