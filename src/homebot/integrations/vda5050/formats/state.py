"""The state of a robot, of versions 2 and 3. Pure.

Source: VDA 5050 2.1 and 3.0, ``state.schema``. Version 3 has other names for a few fields.
"""

import math
from typing import Final, NamedTuple, final

from homebot.conventions.payload import JsonMessage, as_fields, text_of
from homebot.places.rigid import MapPose
from homebot.support.numbers import to_number

MAX_ID: Final = 100
"""Characters of an id that are kept."""

_MAX_READ: Final = 200
"""Entries of a list that are read, the last ones: its last node is the destination of an order."""

_MAX_TOLD: Final = 5
"""Errors that are told."""

_ENDED: Final = frozenset({"FAILED", "FINISHED"})
_AUTOMATIC: Final = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
_STUCK: Final = frozenset({"CRITICAL", "FATAL"})
"""Levels of errors with which a robot does not go on with its order; version 2 has only the second."""

_FARTHEST: Final = 1e6
"""Metres from the origin of a map."""


class RobotError(NamedTuple):
    """An error of a robot, in words, and whether the robot cannot go on."""

    text: str
    is_stuck: bool


@final
class RobotState:
    """The parts of a state message that homebot uses; each is empty if it is missing or wrong.

    Attributes:
        timestamp: When the robot sent it, by its own clock, as text.
        order: The id of the current or the last order.
        last_node: The last node that it reached.
        ahead: The nodes of its order that it has not reached.
        has_order: Whether an order, or an action of one, is not done.
        position: Its pose on its map; None if it does not know it.
        mode: Its operating mode.
    """

    def __init__(self, message: JsonMessage) -> None:
        self.timestamp, self.order = _id(message, "timestamp"), _id(message, "orderId")
        self.version = text_of(message.get("version"), 20)
        self.last_node = _id(message, "lastNodeId")
        self.ahead = tuple(_id(node, "nodeId") for node in _entries(message, "nodeStates"))
        statuses = [action.get("actionStatus") for action in _entries(message, "actionStates")]
        self.is_driving = message.get("driving") is True
        self.is_paused = message.get("paused") is True
        self.has_order = bool(self.ahead) or any(status not in _ENDED for status in statuses)
        self.mode = text_of(message.get("operatingMode"), 20)
        power = as_fields(message.get("batteryState") or message.get("powerSupply"))
        charge = to_number(power.get("batteryCharge", power.get("stateOfCharge")))
        self.charge = charge if charge is not None and 0 <= charge <= 100 else None
        self.charging = _flag(power, "charging")
        self.position, self.map = position_of(message)
        self.errors = tuple(_error(error) for error in _entries(message, "errors"))
        safety = as_fields(message.get("safetyState"))
        stop = safety.get("eStop", safety.get("activeEmergencyStop"))
        self.is_stopped = isinstance(stop, str) and stop != "NONE"
        self.is_blocked = _flag(safety, "fieldViolation")

    @property
    def is_by_hand(self) -> bool:
        """True while the robot takes no orders, such as ``MANUAL`` or ``SERVICE``."""
        return bool(self.mode) and self.mode not in _AUTOMATIC

    @property
    def activity(self) -> str:
        """Its activity, one of :data:`ACTIVITIES`; of several that apply, the gravest."""
        if self.is_stopped or any(error.is_stuck for error in self.errors):
            return "error"
        if self.is_by_hand:
            return "manual"
        if self.is_paused:
            return "paused"
        if self.is_driving or self.has_order:
            return "working"
        return "charging" if self.charging else "idle"

    @property
    def trouble(self) -> str:
        """Its errors in words; ``none`` without one."""
        told = [error.text for error in self.errors[:_MAX_TOLD]]
        rest = len(self.errors) - len(told)
        return "; ".join([*told, *([f"{rest} more"] if rest else [])]) or "none"


ACTIVITIES: Final = ("idle", "working", "paused", "charging", "manual", "error")


def position_of(message: JsonMessage) -> tuple[MapPose | None, str]:
    """Return the position in a ``state`` or ``visualization``, None if the robot does not know it, and its map."""
    fields = as_fields(message.get("agvPosition") or message.get("mobileRobotPosition"))
    if fields.get("positionInitialized", fields.get("localized", True)) is not True:
        return None, ""
    x, y = to_number(fields.get("x")), to_number(fields.get("y"))
    if x is None or y is None or max(abs(x), abs(y)) > _FARTHEST:
        return None, ""
    theta = to_number(fields.get("theta")) or 0.0
    return MapPose(x, y, math.remainder(theta, math.tau)), _id(fields, "mapId")


def _entries(message: JsonMessage, key: str) -> list[JsonMessage]:
    entries = message.get(key)
    return [entry for entry in entries[-_MAX_READ:] if isinstance(entry, dict)] if isinstance(entries, list) else []


def _id(fields: JsonMessage, key: str) -> str:
    return text_of(fields.get(key), MAX_ID)


def _flag(fields: JsonMessage, key: str) -> bool | None:
    flag = fields.get(key)
    return flag if isinstance(flag, bool) else None


def _error(fields: JsonMessage) -> RobotError:
    kind, level = text_of(fields.get("errorType"), 60) or "error", text_of(fields.get("errorLevel"), 20)
    why = text_of(fields.get("errorDescription"))
    text = f"{kind} ({level.lower()})" if level else kind
    return RobotError(f"{text}: {why}" if why else text, level in _STUCK)
