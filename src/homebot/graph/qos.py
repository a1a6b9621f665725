"""Quality of service: offers of publishers, requests of subscriptions, and their matching.

Names, defaults and rules are those of ROS 2 (rclpy ``qos.py``, rmw ``qos_profiles.h``) and DDS.
"""

from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import TypeAlias

from homebot.errors import QosError

KEEP_ALL_LIMIT = 65_536  # bounds KEEP_ALL


class HistoryPolicy(IntEnum):
    """Limit on the number of messages that a queue keeps."""

    KEEP_LAST = 1
    KEEP_ALL = 2


class ReliabilityPolicy(IntEnum):
    """Choice of whether ``await publisher.send()`` waits for the reader.

    In one process nothing is lost on the way; a full KEEP_LAST queue still drops its oldest message, as in ROS.
    """

    RELIABLE = 1
    BEST_EFFORT = 2


class DurabilityPolicy(IntEnum):
    """Choice of whether late joiners receive earlier messages."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class LivelinessPolicy(IntEnum):
    """Method by which a publisher asserts that it is alive."""

    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3


@dataclass(frozen=True, slots=True)
class QoSProfile:
    """The quality of service that one end of a topic offers or requests, as in ROS 2.

    Attributes:
        depth: The number of messages kept, at least 1; per key on a keyed topic.
        history: KEEP_LAST drops the oldest of ``depth`` and counts it; KEEP_ALL is bounded at 65,536.
        durability: TRANSIENT_LOCAL publishers replay their last ``depth`` messages to late TRANSIENT_LOCAL joiners.
        lifespan: Seconds after which a message is no longer delivered; 0 for never.
        deadline: Longest gap between messages, in seconds; 0 for any. Longer gaps are events (``on_event``).
        liveliness: AUTOMATIC, or MANUAL_BY_TOPIC by messages and ``assert_liveliness()``.
        liveliness_lease_duration: Seconds after which a MANUAL_BY_TOPIC publisher is not alive; 0 for never.
    """

    depth: int = 10
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    lifespan: float = 0.0
    deadline: float = 0.0
    liveliness: LivelinessPolicy = LivelinessPolicy.AUTOMATIC
    liveliness_lease_duration: float = 0.0

    def __post_init__(self) -> None:
        if self.depth < 1:
            raise QosError(f"depth must be at least 1, got {self.depth}")
        if min(self.lifespan, self.deadline, self.liveliness_lease_duration) < 0:
            raise QosError("lifespan, deadline and lease duration are seconds and cannot be negative")

    @property
    def queue_depth(self) -> int:
        """The real bound of the queue."""
        return self.depth if self.history is HistoryPolicy.KEEP_LAST else KEEP_ALL_LIMIT

    def to_plain(self) -> dict[str, str | int | float]:
        """Return its fields by name, policies as texts such as ``keep_last``, and the real bound as depth."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        plain = {
            name: value.name.lower() if isinstance(value, IntEnum) else float(value) for name, value in values.items()
        }
        return plain | {"depth": self.queue_depth}


QoSLike: TypeAlias = QoSProfile | int

qos_profile_default = QoSProfile()
qos_profile_services_default = QoSProfile()
qos_profile_sensor_data = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_parameter_events = QoSProfile(depth=1000)
qos_profile_rosout = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=10.0)
qos_profile_latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def to_qos_profile(qos: QoSLike) -> QoSProfile:
    """Return the profile for *qos*; an integer means KEEP_LAST of that depth."""
    return qos if isinstance(qos, QoSProfile) else replace(qos_profile_default, depth=qos)


def qos_incompatibilities(offered: QoSProfile, requested: QoSProfile) -> tuple[str, ...]:
    """Return the reasons why *offered* does not satisfy *requested*; empty if they match.

    History, depth and lifespan do not take part in matching.
    """
    problems = []
    if offered.reliability is ReliabilityPolicy.BEST_EFFORT and requested.reliability is ReliabilityPolicy.RELIABLE:
        problems.append("reliability: best effort is offered, reliable is requested")
    if offered.durability is DurabilityPolicy.VOLATILE and requested.durability is DurabilityPolicy.TRANSIENT_LOCAL:
        problems.append("durability: volatile is offered, transient local is requested")
    if _is_weaker(offered.deadline, requested.deadline):
        problems.append("deadline: the offered one is longer than the requested one")
    if offered.liveliness is LivelinessPolicy.AUTOMATIC and requested.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC:
        problems.append("liveliness: automatic is offered, manual by topic is requested")
    if _is_weaker(offered.liveliness_lease_duration, requested.liveliness_lease_duration):
        problems.append("liveliness lease: the offered one is longer than the requested one")
    return tuple(problems)


def _is_weaker(offered: float, requested: float) -> bool:
    return requested > 0 and (offered == 0 or offered > requested)
