"""Delays for issuers that guess the code of an alarm or a lock."""

from typing import Final, TypeAlias, final

from homebot.clock import Clock
from homebot.control.command import IssuedCommand
from homebot.devices.outcomes import Confirmed, Evidence, Outcome, Refused
from homebot.devices.wording.journal_words import issuer_text
from homebot.support.guess_delays import GuessDelays

__all__ = ["CodeGuesses"]

_POLICY: Final = "code"

_Guesser: TypeAlias = tuple[str, tuple[str, str]]


@final
class CodeGuesses:
    """Delays of commands with a code, by issuer and part, so that nobody else has to wait.

    A code counts as wrong from the time of the command until the part has reported that it obeyed, as many devices do
    not answer a wrong one.

    Attributes:
        refused: The number of commands that came too early.
    """

    def __init__(self, clock: Clock) -> None:
        self.refused = 0
        self._clock = clock
        self._delays: GuessDelays[_Guesser] = GuessDelays()

    def begin(self, command: IssuedCommand) -> Refused | None:
        """Return the refusal of a command with a code that comes too early; otherwise count its code as wrong."""
        guesser, now = (command.issuer, command.place), self._clock.monotonic()
        if (wait := self._delays.until(guesser) - now) > 0:
            self.refused += 1
            codes = f"too many codes without a known effect by {issuer_text(command.issuer)}"
            reason = f"{codes}; try again in {max(wait, 0.1):.1f} s"
            return Refused(_POLICY, reason, command_id=command.id)
        self._delays.failed(guesser, now)
        return None

    def end(self, command: IssuedCommand, outcome: Outcome) -> None:
        """Record the *outcome* of a command that began."""
        is_doubtful = isinstance(outcome, Confirmed) and outcome.evidence is Evidence.ACKNOWLEDGED
        if outcome.succeeded and not is_doubtful:
            self._delays.forgive((command.issuer, command.place))
