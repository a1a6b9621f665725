"""The state of a robot, of versions 2 and 3. Pure.

Source: VDA 5050 2.1 and 3.0, ``state.schema``. Version 3 has other names for a few fields.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Final, NamedTuple, final

from homebot.conventions.payload import JsonMessage, as_fields, text_of
from homebot.places.rigid import MapPose
from homebot.support.numbers import to_number

MAX_ID: Final = 100
"""Characters of an id that are kept."""

_MAX_READ: Final = 200
"""Entries of a list that are read, the last ones: its last node is the destination of an order."""

_MAX_REFERENCE: Final = 300
"""Characters of the id of an order or action that are compared."""

_LATE: Final = timedelta(minutes=1)
"""The longest time by which a message comes later than the next one; two starts of a robot are farther apart."""

_MAX_TOLD: Final = 5
"""Errors that are told."""

_ENDED: Final = frozenset({"FAILED", "FINISHED"})
_AUTOMATIC: Final = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
_STUCK: Final = frozenset({"CRITICAL", "FATAL"})
"""Levels of errors with which a robot does not go on with its order; version 2 has only the second."""

_REFERENCES: Final = frozenset({"orderId", "actionId"})

_FARTHEST: Final = 1e6
"""Metres from the origin of a map."""


class RobotError(NamedTuple):
    """An error of a robot, in words, and whether the robot cannot go on."""

    text: str
    is_stuck: bool


class MessageHeader(NamedTuple):
    """The number of a message among those on its topic, and when the robot sent it; None if it does not say so."""

    number: int | None
    sent_at: datetime | None

    def is_late(self, last: MessageHeader) -> bool:
        """Return whether the message was overtaken by *last*: one of a robot that counts anew is of another time."""
        if self.number is None or last.number is None or self.sent_at is None or last.sent_at is None:
            return False
        return self.number < last.number and timedelta() <= last.sent_at - self.sent_at <= _LATE


@final
class RobotState:
    """The parts of a state message that homebot uses; each is empty if it is missing or wrong.

    Attributes:
        timestamp: When the robot sent it, by its own clock, as text.
        refusals: Why the robot refuses an order or an action, by its id.
        last_node: The last node that it reached.
        ahead: The nodes of its order that it has not reached.
        has_order: Whether an order, or an action of one, is not done.
        header: Its number and time.
        position: Its pose on its map; None if it does not know it, or tells none.
        is_lost: Whether it says that it does not know its pose.
        mode: Its operating mode.
    """

    def __init__(self, message: JsonMessage) -> None:
        self.timestamp, self.header = _id(message, "timestamp"), header_of(message)
        self.version = text_of(message.get("version"), 20)
        self.last_node = _id(message, "lastNodeId")
        self.ahead = tuple(_id(node, "nodeId") for node in entries_of(message, "nodeStates"))
        statuses = [action.get("actionStatus") for action in entries_of(message, "actionStates")]
        self.is_driving = message.get("driving") is True
        self.is_paused = message.get("paused") is True
        self.has_order = bool(self.ahead) or any(status not in _ENDED for status in statuses)
        self.mode = text_of(message.get("operatingMode"), 20)
        power = as_fields(message.get("batteryState") or message.get("powerSupply"))
        charge = to_number(power.get("batteryCharge", power.get("stateOfCharge")))
        self.charge = charge if charge is not None and 0 <= charge <= 100 else None
        self.charging = _flag(power, "charging")
        self.position, self.map = position_of(message)
        self.is_lost = self.position is None and bool(_position_fields(message))
        self.errors = tuple(_error(error) for error in entries_of(message, "errors"))
        taken = reference_of(message.get("orderId")) if self.has_order else ""  # an error of it is no refusal
        self.refusals = {name: why for name, why in _refusals(message) if name and name != taken}
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
    fields = _position_fields(message)
    if fields.get("positionInitialized", fields.get("localized", True)) is not True:
        return None, ""
    x, y = to_number(fields.get("x")), to_number(fields.get("y"))
    if x is None or y is None or max(abs(x), abs(y)) > _FARTHEST:
        return None, ""
    theta = to_number(fields.get("theta")) or 0.0
    return MapPose(x, y, math.remainder(theta, math.tau)), _id(fields, "mapId")


def reference_of(value: object) -> str:
    """Return the id of an order or action as errors refer to it; empty if it is none."""
    return text_of(value, _MAX_REFERENCE)


def _position_fields(message: JsonMessage) -> JsonMessage:
    return as_fields(message.get("agvPosition") or message.get("mobileRobotPosition"))


def _refusals(message: JsonMessage) -> Iterator[tuple[str, str]]:
    """Yield the orders and actions that failed, each with the reason; of several the last counts."""
    for action in (*entries_of(message, "actionStates"), *entries_of(message, "instantActionStates")):
        if action.get("actionStatus") == "FAILED":
            why = text_of(action.get("resultDescription", action.get("actionResult")))
            failed = f"{text_of(action.get('actionType'), 60) or 'an action'} failed"
            yield reference_of(action.get("actionId")), f"{failed}: {why}" if why else failed
    for error in entries_of(message, "errors"):
        for reference in entries_of(error, "errorReferences"):
            if reference.get("referenceKey") in _REFERENCES:
                yield reference_of(reference.get("referenceValue")), _error(error).text


def header_of(message: JsonMessage) -> MessageHeader:
    """Return the header of any message of a robot."""
    number = message.get("headerId")
    try:
        time = datetime.fromisoformat(_id(message, "timestamp"))
    except ValueError:
        time = None
    sent_at = time if time is None or time.tzinfo is not None else time.replace(tzinfo=UTC)
    return MessageHeader(number if isinstance(number, int) else None, sent_at)


def entries_of(message: JsonMessage, key: str) -> list[JsonMessage]:
    """Return the objects in a list of *message*, of a long one the last."""
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
