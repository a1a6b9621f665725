"""A limit for issuers that guess the code of an alarm or a lock."""

from typing import Final, TypeAlias, final

from homebot.clock import Clock
from homebot.control.command import IssuedCommand
from homebot.devices.outcomes import Confirmed, Evidence, Outcome, Refused
from homebot.devices.wording.journal_words import issuer_text
from homebot.support.bounded_map import BoundedMap
from homebot.support.limits import RateLimit

_POLICY: Final = "code"
_AT_ONCE: Final = 4.0  # people mistype
_INTERVAL_S: Final = 8.0
_MAX_GUESSERS: Final = 1000

_Guesser: TypeAlias = tuple[str, tuple[str, str]]


@final
class CodeGuesses:
    """The rates of commands with a code, by issuer and part, so that others need not wait.

    A code counts from the time of the command until the part has reported that it obeyed, as many devices do not answer
    a wrong one. Of a part that reports no effect, all codes count.

    Attributes:
        refused: The number of commands that came too early.
    """

    def __init__(self, clock: Clock) -> None:
        self.refused = 0
        self._clock = clock
        self._limits: BoundedMap[_Guesser, RateLimit] = BoundedMap(_MAX_GUESSERS)

    def begin(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of a command with a code that comes too early; otherwise count its code."""
        guesser, now = (command.issuer, command.place), self._clock.monotonic()
        limit = self._limits[guesser] = self._limits.get(guesser) or RateLimit(1 / _INTERVAL_S, _AT_ONCE)
        if limit.admits(now):
            return None
        self.refused += 1
        issuer, wait = issuer_text(command.issuer), max((1 - limit.room(now)) * _INTERVAL_S, 0.1)
        why = f"too many codes without a known effect by {issuer}"
        if not any(
            capability.readable and capability.name in command.settings for capability in command.part.part.capabilities
        ):
            why = f"{command.label} reports no effect of a code, so {issuer} may give one every {_INTERVAL_S:g} s"
        return Refused(_POLICY, f"{why}; try again in {wait:.1f} s", command_id=command.id)

    def end(self, command: IssuedCommand, outcome: Outcome) -> None:
        """Record the *outcome* of a command that began."""
        is_doubtful = isinstance(outcome, Confirmed) and outcome.evidence is Evidence.ACKNOWLEDGED
        limit = self._limits.get((command.issuer, command.place))
        if limit is not None and outcome.succeeded and not is_doubtful:
            limit.charge(self._clock.monotonic(), -1)
