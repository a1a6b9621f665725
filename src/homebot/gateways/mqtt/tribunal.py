"""Who breaks the rules of a gateway: told, counted, and in the end not listened to for a while."""

from __future__ import annotations

from functools import partial

from homebot.devices.quarantine import Quarantine
from homebot.gateways.base import Gateway
from homebot.gateways.mqtt.board import Board
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.offenders import Offender, Offenders
from homebot.gateways.mqtt.timekeeper import Timekeeper
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.isolation import crash_of
from homebot.log import LogLimit
from homebot.messages import Time

__all__ = ["Tribunal"]

QUARANTINED = "gateway.quarantined"
CONVENTION_FAILED = "gateway.convention_failed"

MAX_WARNINGS = 20
"""Lines of one kind in ten seconds, each about another culprit."""

_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_LONGEST = 300
"""Characters of a topic, or of a reason, that are remembered."""


class Tribunal:
    """Judges offenders, who are called by the topic that they speak on.

    Args:
        gateway: In whose name.
        board: Has the time.
        timekeeper: Ends each quarantine.
        counters: Of the gateway.
    """

    def __init__(self, gateway: Gateway, board: Board, timekeeper: Timekeeper, counters: GatewayCounters) -> None:
        self._node = gateway.node
        self._board = board
        self._timekeeper = timekeeper
        self._counters = counters
        self._offenders = Offenders()
        self._events = gateway.node.create_publisher(Quarantine, gateway.names.quarantine, _QOS)
        self._limit = LogLimit(gateway.node.graph.clock)
        self._flood_limit = LogLimit(gateway.node.graph.clock, burst=MAX_WARNINGS)

    @property
    def forgotten(self) -> int:
        """How many offenders were forgotten for want of room."""
        return self._offenders.forgotten

    def is_confined(self, topic: str) -> bool:
        """Whether who speaks on *topic* is quarantined."""
        return self._offenders.is_confined(topic[:_LONGEST])

    def accuse(self, topic: str, event: str, why: str) -> None:
        """Tell of an offence on *topic*, and quarantine who repeats it."""
        topic, why = topic[:_LONGEST], why[:_LONGEST]
        self.warn(event, f"{topic}: {why}", topic=topic)
        offender = self._offenders.offend(topic, why, self._board.now)
        if offender is not None:
            self._counters.quarantines += 1
            self._timekeeper.plan(("quarantine", topic), offender.until - offender.since, partial(self._release, topic))
            self._events.publish(self._message(offender))
            self.warn(
                QUARANTINED,
                f"not listened to for {(offender.until - offender.since) / 60:.0f} min: {topic} broke the rules again "
                f"and again, the last one: {why}",
                topic=topic,
            )

    def failed(self, topic: str, convention: str, error: BaseException) -> None:
        """Tell of an *error* that a convention let through; it counts as an offence.

        One that a stranger's message causes must not end the gateway, which would meet the same message again. As a
        convention waits for nothing, no cancellation that it lets through can be meant for the gateway.

        Raises:
            KeyboardInterrupt: *error* is one.
        """
        error = crash_of(f"the convention {convention}", error)
        self._counters.failures += 1
        if self._limit.allows(f"{CONVENTION_FAILED} {convention}") is not None:
            self._node.log.error(
                CONVENTION_FAILED, message=f"the convention {convention} failed", topic=topic[:_LONGEST], exc_info=error
            )
        self.accuse(topic, CONVENTION_FAILED, f"the convention {convention} failed")

    def warn(self, event: str, words: str, *, topic: str) -> None:
        """Tell of a culprit once in a while, and of so many culprits at most."""
        topic = topic[:_LONGEST]
        repeated = self._limit.allows(f"{event} {topic}")
        if repeated is None or (unheard := self._flood_limit.allows(event)) is None:
            return
        held_back = repeated + unheard
        more = f" (and {held_back} more like this)" if held_back else ""
        self._node.log.warning(event, message=f"{words}{more}", topic=topic, held_back=held_back)

    def confined(self) -> tuple[Quarantine, ...]:
        """Return who is quarantined now."""
        return tuple(self._message(offender) for offender in self._offenders.confined())

    def _release(self, topic: str) -> None:
        offender = self._offenders.release(topic)
        if offender is not None:
            self._events.publish(self._message(offender).model_copy(update={"is_over": True}))
            self._events.dispose(topic)

    def _message(self, offender: Offender) -> Quarantine:
        passed = self._node.graph.clock.monotonic() - offender.since
        since = self._node.graph.clock.now() - passed
        return Quarantine(
            gateway=self._node.name,
            offender=offender.name,
            why=offender.why,
            offences=offender.offences,
            since=Time.from_seconds(since),
            until=Time.from_seconds(since + offender.until - offender.since),
        )
