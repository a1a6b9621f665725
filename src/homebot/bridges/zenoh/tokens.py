"""Tokens, by which ROS 2 nodes on Zenoh tell each other of their entities, and the keys of these. Pure.

Source: rmw_zenoh, ``docs/design.md`` and ``liveliness_utils.cpp``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, Self

import xxhash

from homebot.bridges.zenoh.qos_text import qos_from_text, qos_to_text
from homebot.errors import TypeMismatchError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.qos import QoSProfile
from homebot.names import full_node_name, validate_full_name

ALL_TOKENS: Final = "@ros2_lv/{domain}/**"
"""The key expression of all tokens of a domain."""

NO_HASH: Final = "TypeHashNotSupported"
"""In place of the hash of a type in ROS 2 Humble, which has none."""

_ROOT: Final = "@ros2_lv"
_KINDS: Final = {
    "NN": EntityKind.NODE,
    "MP": EntityKind.PUBLISHER,
    "MS": EntityKind.SUBSCRIPTION,
    "SS": EntityKind.SERVICE,
    "SC": EntityKind.CLIENT,
}
_WORDS: Final = {kind: word for word, kind in _KINDS.items()}
MAX_CHARACTERS: Final = 4000
"""Characters of a token; its names have 255 at most."""

_OF_NODE, _OF_ENTITY, _OF_TYPE = 9, 13, 4
"""The number of parts; newer versions append more."""


@dataclass(frozen=True, slots=True)
class EntityToken:
    """One entity of a ROS 2 node.

    Attributes:
        session: The Zenoh id of its process.
        ids: The numbers of its node and of itself in that process.
        info: The entity.
        type_hash: The hash of its type; empty for a node.
        enclave: Its security enclave; ``/`` for none.
        is_bridged: Whether zenoh-bridge-ros2dds speaks for it: its messages have no attachment.
    """

    is_bridged: ClassVar[bool] = False

    domain: int
    session: str
    ids: tuple[int, int]
    info: EndpointInfo
    type_hash: str = ""
    enclave: str = "/"

    @property
    def text(self) -> str:
        """The key expression that is declared."""
        info = self.info
        namespace, _, node = info.node.rpartition("/")
        parts = [_ROOT, str(self.domain), self.session, *map(str, self.ids), _WORDS[info.kind]]
        parts += [_escape(self.enclave), _escape(namespace or "/"), node]
        if info.kind is not EntityKind.NODE:
            qos = qos_to_text(info.qos or QoSProfile())
            parts += [_escape(info.name), _wire_type(info.ros_type), self.type_hash, qos]
        return "/".join(parts)

    @property
    def gid(self) -> bytes:
        """The 16 bytes that identify the entity as the writer of a message."""
        return gid_of(self.text)

    @property
    def key(self) -> str:
        """The key of its data, or of its requests."""
        return data_key(self.domain, self.info.name, self.info.ros_type, self.type_hash)

    def difference(self, own: Self) -> str:
        """Return how the type differs from that of *own*, the entity here with the same name; empty if it does not."""
        info = self.info
        who = f"{info.name} of {info.node}"
        if info.ros_type != own.info.ros_type:
            return f"{who} is a {info.ros_type}, here a {own.info.ros_type}"
        if self.type_hash == own.type_hash:
            return ""
        if self.type_hash == NO_HASH:
            return f"{who} has no hash of its type, as in ROS 2 Humble, which homebot only listens to; use Jazzy"
        return (
            f"{who} has another {info.ros_type}: its hash is {self.type_hash}, here {own.type_hash}; "
            "name a folder with the definition of the robot in interfaces of [ros], or its distro there"
        )

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Return the token that *text* is; parts that newer versions append are ignored.

        Raises:
            TypeMismatchError: It is none; the message says why.
        """
        parts = text.split("/") if len(text) <= MAX_CHARACTERS else []
        kind = _KINDS.get(parts[5]) if len(parts) >= _OF_NODE and parts[0] == _ROOT else None
        if kind is None or len(parts) < (_OF_NODE if kind is EntityKind.NODE else _OF_ENTITY) or "" in parts:
            raise TypeMismatchError(f"{text[:200]!r} is no token of a ROS 2 node")
        try:
            domain, node_id, entity_id = int(parts[1]), int(parts[3]), int(parts[4])
        except ValueError:
            raise TypeMismatchError(f"{text[:200]!r} is no token of a ROS 2 node: a number is none") from None
        type_hash = "" if kind is EntityKind.NODE else parts[11]
        return cls(domain, parts[2], (node_id, entity_id), _info_in(parts, kind), type_hash, _unescape(parts[6]))


def data_key(domain: int, name: str, ros_type: str, type_hash: str) -> str:
    """Return the key of the topic or service with the full name *name*."""
    return f"{domain}/{name.removeprefix('/')}/{_wire_type(ros_type)}/{type_hash}"


def gid_of(token: str) -> bytes:
    """Return the 16 bytes that identify the entity with the text *token*: its XXH3 hash, the low half first."""
    high_first = xxhash.xxh3_128_digest(token.encode())
    return high_first[:7:-1] + high_first[7::-1]


def _info_in(parts: Sequence[str], kind: EntityKind) -> EndpointInfo:
    node = full_node_name(parts[8], _unescape(parts[7]))
    if kind is EntityKind.NODE:
        return EndpointInfo(kind, node, node)
    qos = qos_from_text(parts[12])
    name = validate_full_name(_unescape(parts[9]), "name in a token")
    is_topic = kind in {EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION}
    return EndpointInfo(kind, node, name, _ros_type(parts[10]), qos if is_topic else None)


def _wire_type(ros_type: str) -> str:
    """Return ``std_msgs::msg::dds_::String_`` for ``std_msgs/msg/String``."""
    package, kind, name = ros_type.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def _ros_type(text: str) -> str:
    parts = text.split("::")
    if len(parts) != _OF_TYPE or parts[2] != "dds_" or not parts[3].endswith("_"):
        raise TypeMismatchError(f"{text[:100]!r} is no type of ROS 2 such as std_msgs::msg::dds_::String_")
    return f"{parts[0]}/{parts[1]}/{parts[3][:-1]}"


def _escape(name: str) -> str:
    return name.replace("/", "%")


def _unescape(text: str) -> str:
    return text.replace("%", "/")
