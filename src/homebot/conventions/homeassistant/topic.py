"""Topics in discovery: where configs are, and which topics a config may name. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/discovery.py`` and ``util.py``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from homebot.conventions.payload import shown
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.topics import validate_filter, validate_topic

__all__ = ["DEVICE", "ConfigTopic", "command_topic", "parse_config_topic", "state_topic"]

DEVICE = "device"
"""In the place of the component: the message describes a whole device."""


@dataclass(frozen=True, slots=True)
class ConfigTopic:
    """The parts of a config's topic.

    Attributes:
        component: For example ``light``, or :data:`DEVICE`.
        node_id: The level between component and object; empty where there is none.
        object_id: The level before ``config``.
    """

    component: str
    node_id: str
    object_id: str

    @property
    def key(self) -> str:
        """The name of the announcement: all levels between prefix and ``config``."""
        ids = f"{self.node_id}/{self.object_id}" if self.node_id else self.object_id
        return f"{self.component}/{ids}"


def parse_config_topic(prefix: str, topic: str) -> ConfigTopic | None:
    """Return what *topic* says; None where it is no config below *prefix*.

    Home Assistant takes ids of letters, digits, ``_`` and ``-`` alone. Real devices have others too, such as the button
    ``recall_*`` of a remote; they are taken as they are.

    Raises:
        WireError: It is a config, but longer than 512 characters.
    """
    if not topic.startswith(f"{prefix}/") or not topic.endswith("/config"):
        return None
    levels = topic[len(prefix) + 1 : -len("/config")].split("/")
    if len(levels) not in _LEVELS:
        return None
    if len(topic) > _MAX_CONFIG_TOPIC:
        raise WireError(f"topic {shown(topic)} is {len(topic)} long; {_MAX_CONFIG_TOPIC} is the limit for a config")
    component, *ids = levels
    return ConfigTopic(component, ids[0] if len(ids) > 1 else "", ids[-1])


@lru_cache(maxsize=128)
def command_topic(topic: str) -> str:
    """Return *topic* where a command may be published to it.

    Raises:
        WireError: It is empty, has a wildcard or a control character, or breaks MQTT's rules.
    """
    return _checked(topic, is_filter=False)


@lru_cache(maxsize=128)
def state_topic(topic: str) -> str:
    """Return *topic* where it may be subscribed to; whole levels may be wildcards.

    Raises:
        WireError: It is empty, has a control character, or breaks MQTT's rules.
    """
    return _checked(topic, is_filter=True)


_LEVELS = (2, 3)
_MAX_CONFIG_TOPIC = 512
_FORBIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\ufdd0-\ufdef\ufffe\uffff]")


def _checked(topic: str, *, is_filter: bool) -> str:
    try:
        if is_filter:
            validate_filter(topic)
        else:
            validate_topic(topic)
    except InvalidNameError as error:
        raise WireError(f"topic {shown(topic)} {error.problem}") from None
    if _FORBIDDEN.search(topic):
        raise WireError(f"topic {shown(topic)} has a control character")
    return topic
