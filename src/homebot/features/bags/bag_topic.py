"""A topic of a bag, with all that a reader needs to decode its messages. Pure."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple, final

from homebot.messages.interfaces import Interfaces
from homebot.messages.interfaces.interface_text import split_definitions
from homebot.messages.message import Message
from homebot.messages.type_hash import type_hash

CDR: Final = ("cdr", "ros2msg")
"""The encodings that homebot reads."""

_POLICIES: Final = ("history", "reliability", "durability", "liveliness", "depth")
_SPANS: Final = ("deadline", "lifespan", "liveliness_lease_duration")
_INFINITE: Final = {"sec": 9_223_372_036, "nsec": 854_775_807}


@final
@dataclass(frozen=True, slots=True)
class BagTopic:
    """A topic and its type.

    Attributes:
        definition: The text of the type and of those in it, like that of
            :func:`homebot.messages.definition.definition_text`.
        qos: The offers of its publishers, as :func:`qos_text`.
        encodings: Those of its messages and of *definition*; ``ros2idl`` for a type in IDL, empty for an unknown one.
    """

    name: str
    ros_type: str
    definition: str
    type_hash: str
    qos: str
    encodings: tuple[str, str] = CDR

    @classmethod
    def of(cls, name: str, ros_type: str, definition: str, qos: str) -> BagTopic:
        """Return the topic *name* with messages of the type with the text *definition*.

        Raises:
            UsageError: The text is none.
        """
        topic = cls(name, ros_type, definition, "", qos)
        return replace(topic, type_hash=type_hash(topic.message_type()))

    @property
    def is_latched(self) -> bool:
        """True if late subscribers got messages from before; ROS 2 wrote numbers before Jazzy."""
        return re.search(r'durability"?: "?(transient_local|1)\b', self.qos) is not None

    def message_type(self) -> type[Message]:
        """Return the type of the messages, built from its text.

        Raises:
            UsageError: The text is none.
        """
        return Interfaces(split_definitions(self.ros_type, self.definition)).find_message(self.ros_type)


class BagMessage(NamedTuple):
    """A message in CDR.

    Attributes:
        at: When it was received, in nanoseconds since 1970.
    """

    topic: BagTopic
    at: int
    data: bytes


def qos_text(offered: Iterable[Mapping[str, Any]]) -> str:
    """Return the profiles that publishers *offered*, as :meth:`QoSProfile.to_plain`, in the form of rosbag2: YAML."""
    return json.dumps([_profile(profile) for profile in offered])


def _profile(plain: Mapping[str, Any]) -> dict[str, Any]:
    kept = {name: plain[name] for name in _POLICIES} | {"avoid_ros_namespace_conventions": False}
    return kept | {name: _span(plain[name]) for name in _SPANS}


def _span(seconds: float) -> dict[str, int]:
    sec, nsec = divmod(round(seconds * 1e9), 1_000_000_000)
    return {"sec": sec, "nsec": nsec} if seconds else _INFINITE
