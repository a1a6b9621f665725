"""Quality of service in the tokens of rmw_zenoh, for example ``::,10:,:,:,,``, and of zenoh-bridge-ros2dds. Pure.

A value that is the default of rmw_zenoh is empty, and of the bridge one that DDS does not state. Sources: rmw_zenoh,
``liveliness_utils.cpp``; zenoh-plugin-ros2dds 1.x, ``liveliness_mgt.rs``.
"""

from enum import IntEnum
from typing import Final, TypeVar

from homebot.errors import TypeMismatchError
from homebot.graph.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

PolicyT = TypeVar("PolicyT", bound=IntEnum)

_DEFAULT: Final = QoSProfile()
_INFINITE: Final = 9_223_372_036
"""Seconds that ROS 2 writes for no limit; homebot has 0."""

_TOO_LARGE: Final = 2**63
_DEEPEST: Final = 1000
"""The messages of a history that are kept; a deeper one would be in memory here too."""

_MAX_TEXT: Final = 300
"""Characters, more than numbers of 64 bits need."""

_FIELDS: Final = (1, 1, 2, 2, 2, 3)
"""How many numbers there are between the colons."""

_RELIABILITY_OF_DDS: Final = {
    "": ReliabilityPolicy.RELIABLE,
    "0": ReliabilityPolicy.BEST_EFFORT,
    "1": ReliabilityPolicy.RELIABLE,
}
_DURABILITY_OF_DDS: Final = {
    "": DurabilityPolicy.VOLATILE,
    "0": DurabilityPolicy.VOLATILE,
    "1": DurabilityPolicy.TRANSIENT_LOCAL,
}
_HISTORY_OF_DDS: Final = {"0": HistoryPolicy.KEEP_LAST, "1": HistoryPolicy.KEEP_ALL}


def qos_to_text(qos: QoSProfile) -> str:
    """Return *qos* as rmw_zenoh writes it: of the defaults only the depth."""
    reliability = _policy(qos.reliability, _DEFAULT.reliability)
    durability = _policy(qos.durability, _DEFAULT.durability)
    history = f"{_policy(qos.history, _DEFAULT.history)},{qos.depth}"
    liveliness = f"{_policy(qos.liveliness, _DEFAULT.liveliness)},{_duration(qos.liveliness_lease_duration)}"
    return ":".join((reliability, durability, history, _duration(qos.deadline), _duration(qos.lifespan), liveliness))


def qos_from_text(text: str) -> QoSProfile:
    """Return the profile that *text* is.

    Raises:
        TypeMismatchError: It has not the form.
    """
    try:
        if len(text) > _MAX_TEXT:
            raise ValueError
        fields = [[int(number or -1) for number in field.split(",")] for field in text.split(":")]
        if tuple(map(len, fields)) != _FIELDS or max(map(max, fields)) >= _TOO_LARGE:
            raise ValueError
        (reliability,), (durability,), (history, depth), deadline, lifespan, (liveliness, *lease) = fields
        return QoSProfile(
            depth=min(max(depth, 1), _DEEPEST) if depth >= 0 else _DEFAULT.depth,
            history=_read(history, _DEFAULT.history),
            reliability=_read(reliability, _DEFAULT.reliability),
            durability=_read(durability, _DEFAULT.durability),
            lifespan=_seconds(*lifespan),
            deadline=_seconds(*deadline),
            liveliness=_read(liveliness, _DEFAULT.liveliness),
            liveliness_lease_duration=_seconds(*lease),
        )
    except ValueError:
        raise TypeMismatchError(
            f"{text[:100]!r} is no quality of service of rmw_zenoh, such as '::,10:,:,:,,'"
        ) from None


def qos_from_bridge(text: str) -> tuple[QoSProfile, str]:
    """Return the profile that *text* is in zenoh-bridge-ros2dds, such as ``:1:1:0,10``, and the data of users in it.

    Raises:
        TypeMismatchError: It has not the form.
    """
    try:
        _keys, reliability, durability, kind_and_depth, *user_data = text.split(":", 4)
        kind, depth = (kind_and_depth or "0,1").split(",")
        profile = QoSProfile(
            depth=min(max(int(depth), 1), _DEEPEST),
            history=_HISTORY_OF_DDS[kind],
            reliability=_RELIABILITY_OF_DDS[reliability],
            durability=_DURABILITY_OF_DDS[durability],
        )
    except (KeyError, ValueError):
        raise TypeMismatchError(
            f"{text[:100]!r} is no quality of service of zenoh-bridge-ros2dds, such as ':1:0:0,10'"
        ) from None
    return profile, "".join(user_data)


def _policy(value: IntEnum, default: IntEnum) -> str:
    return "" if value == default else str(int(value))


def _read(number: int, default: PolicyT) -> PolicyT:
    return default if number <= 0 else type(default)(number)


def _duration(seconds: float) -> str:
    if not seconds:
        return ","
    whole, rest = divmod(round(seconds * 1e9), 1_000_000_000)
    return f"{whole},{rest}"


def _seconds(whole: int, rest: int) -> float:
    return 0.0 if whole < 0 or whole >= _INFINITE else whole + max(rest, 0) / 1e9
