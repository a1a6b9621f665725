"""Tokens of robots behind zenoh-bridge-ros2dds, whose keys have neither domain nor type. Pure.

Source: zenoh-plugin-ros2dds 1.x, ``liveliness_mgt.rs``, ``ros2_utils.rs``, ``route_action_srv.rs``,
``route_publisher.rs``.
"""

from dataclasses import dataclass
from typing import ClassVar, Final, Self

from homebot.bridges.zenoh.qos_text import qos_from_bridge
from homebot.bridges.zenoh.tokens import MAX_CHARACTERS, NO_HASH, EntityToken
from homebot.errors import TypeMismatchError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.qos import QoSProfile
from homebot.names import validate_full_name

ALL_BRIDGE_TOKENS: Final = "@/*/@ros2_lv/**"
"""The key expression of the tokens of all bridges."""

BRIDGED_ENTITY: Final = "@/*/@ros2_lv/{kind}/{name}/**"
READ_KINDS: Final = ("MP", "SS", "AS")
"""The tokens of publishers, services and actions, which are read."""

SLASH: Final = "§"
"""In place of the slashes in names and types."""

CACHE: Final = "@/{session}/@ros2_pub_cache/{key}"
"""The key at which a bridge answers with its latched messages."""

_UNREAD: Final = ("MS", "SC", "AC")
_NODE: Final = "zenoh_bridge_ros2dds"
_PARTS_OF_TYPE: Final = 3
_OF_ACTION: Final = (
    "SS/{name}§_action§send_goal/{ros_type}_SendGoal",
    "SS/{name}§_action§cancel_goal/action_msgs§srv§CancelGoal",
    "SS/{name}§_action§get_result/{ros_type}_GetResult",
    "MP/{name}§_action§feedback/{ros_type}_FeedbackMessage/:1:0:0,10",
    "MP/{name}§_action§status/action_msgs§msg§GoalStatusArray/:1:1:0,1",
)
"""The services and topics of an action, for which the bridge has no tokens."""


@dataclass(frozen=True, slots=True)
class BridgeToken(EntityToken):
    """One topic or service of a robot behind a bridge, which does not tell its node."""

    is_bridged: ClassVar[bool] = True

    @property
    def key(self) -> str:
        """The key of its data, or of its requests."""
        return self.info.name[1:]

    @property
    def cache(self) -> str:
        """The key of its latched messages."""
        return CACHE.format(session=self.session, key=self.key)

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Return the token that *text* is.

        Raises:
            TypeMismatchError: It is none of a topic or service; the message says why.
            InvalidNameError: Its key is no name of ROS 2.
        """
        qos: QoSProfile | None = None
        type_hash = NO_HASH
        match text.split("/") if len(text) <= MAX_CHARACTERS else ():
            case ["@", session, "@ros2_lv", "MP", key, wire_type, profile]:
                kind = EntityKind.PUBLISHER
                qos, user_data = qos_from_bridge(profile)
                facts = dict(fact.split("=", 1) for fact in user_data.split(";") if "=" in fact)
                type_hash = facts.get("typehash") or NO_HASH
            case ["@", session, "@ros2_lv", "SS", key, wire_type]:
                kind = EntityKind.SERVICE
            case _:
                raise TypeMismatchError(f"{text[:200]!r} is no token of zenoh-bridge-ros2dds")
        parts = wire_type.split(SLASH)
        if len(parts) != _PARTS_OF_TYPE or not all(part.isidentifier() for part in parts) or not session.isalnum():
            raise TypeMismatchError(f"{text[:200]!r} is no token of zenoh-bridge-ros2dds: its id or type is none")
        name = validate_full_name(f"/{key.replace(SLASH, '/')}", "name in a token")
        space = name[: name.find("/", 1)] if "/" in name[1:] else ""
        info = EndpointInfo(kind, f"{space}/{_NODE}", name, "/".join(parts), qos)
        return cls(0, session, (0, 0), info, type_hash)


def entity_texts(text: str) -> tuple[str, ...]:
    """Return the tokens of the entities for which the token *text* stands: five for an action of a bridge.

    There are none for a bridge itself, and for what uses topics, services and actions of others.
    """
    match text.split("/", 6):
        case ["@", _, "@ros2_lv"]:
            return ()
        case ["@", _, "@ros2_lv", kind, *_] if kind in _UNREAD:
            return ()
        case ["@", session, "@ros2_lv", "AS", name, ros_type]:
            parts = (part.format(name=name, ros_type=ros_type) for part in _OF_ACTION)
            return tuple(f"@/{session}/@ros2_lv/{part}" for part in parts)
    return (text,)


def token_of_text(text: str) -> EntityToken:
    """Return the token that *text* is, of rmw_zenoh or of a bridge.

    Raises:
        HomebotError: It is none; the message says why.
    """
    return (BridgeToken if text.startswith("@/") else EntityToken).of_text(text)
