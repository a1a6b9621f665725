"""Sendings of one command, and what the network answered: a fold of their facts. Pure."""

import math
from typing import final

from homebot.control.timeline.facts import Answered, Asked, CommandFact, LinkLost, SendingEnded, Sent, Withheld


@final
class Transmission:
    """The sendings of one command so far.

    Attributes:
        attempts: The number of sendings that ended, including withheld ones.
        count: The number of sendings that began.
        first_sent_at: When the first sending began; when the command was given, before.
        sent_at: The same of the last sending.
        told_at: When the first sending to this part alone began; None if the first of all was one.
        began: When the first sending ended, since a gateway may have had to connect first; -inf before.
        asked_at: When the last attempt ended; -inf before.
        asked_after: The number of attempts after which the part was last asked for its values.
        can_be_asked: Whether it takes such a request, as far as is known.
        lost_at: When the connection was last lost, or did not answer; -inf for never.
        is_unacknowledged: Whether the network did not acknowledge the last sending in time.
        accepted: When the device or its network first accepted each setting.
        refusal: The reason why the device refuses the command; empty if it does not.
        routes: The routes that accepted settings, in order, if the part has several.
        echoed: The capabilities that a bridge reports once without having heard from the part, because a message to a
            group took the place of the first sending.
    """

    attempts = count = asked_after = 0
    can_be_asked = True
    told_at: float | None = None
    began = asked_at = lost_at = -math.inf
    is_unacknowledged = _is_shared = False
    refusal = ""
    routes: tuple[str, ...] = ()
    echoed: frozenset[str] = frozenset()

    def __init__(self, given_at: float) -> None:
        self.first_sent_at = self.sent_at = given_at
        self.accepted: dict[str, float] = {}

    def apply(self, fact: CommandFact) -> None:
        """Add the next fact."""
        if isinstance(fact, Sent):
            self.sent_at = fact.at
            self.first_sent_at = fact.at if self.count == 0 else self.first_sent_at
            self.told_at = fact.at if self.count == 1 and self._is_shared else self.told_at
            self.count += 1
            self.is_unacknowledged = False
        elif isinstance(fact, SendingEnded | Withheld):
            self.attempts += 1
            self.asked_at = fact.at
            if isinstance(fact, SendingEnded):
                self.routes += fact.routes
                self._is_shared = fact.is_shared
                self.is_unacknowledged = fact.is_unacknowledged
                self.lost_at = fact.at if fact.is_unacknowledged else self.lost_at
            if self.attempts == 1:
                self.began = self.sent_at if self.is_unacknowledged else fact.at
        elif isinstance(fact, Asked):
            self.asked_after, self.can_be_asked = self.attempts, fact.can_answer
        elif isinstance(fact, LinkLost):
            self.lost_at = max(self.lost_at, fact.at)
        elif isinstance(fact, Answered):
            if fact.problem:
                self.refusal = self.refusal or fact.problem
            else:
                self.accepted.setdefault(fact.capability, fact.at)
