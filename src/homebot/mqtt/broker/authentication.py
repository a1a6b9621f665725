"""Authentication of clients: passwords, growing delays for hosts that guess them, waiting logins. No I/O."""

import hmac
import secrets
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple, final

from homebot.clock import Clock
from homebot.mqtt.broker.ports import ConnectedClient
from homebot.mqtt.packets import ReasonCode
from homebot.support.addresses import network_of
from homebot.support.bounded_map import BoundedMap

_NOBODYS = bytes(32)


_FREE: Final = 3  # wrong secrets without a delay: people mistype
_FIRST: Final = 0.5
_MAX_DELAY_S: Final = 8.0
"""Seconds; less than a CONNECT may wait, so that an honest client on the same host gets its chance."""

_FORGOTTEN: Final = 600.0  # seconds after the last wrong secret
_MAX_HOSTS: Final = 1000


class _Guesses:
    __slots__ = ("failed_at", "failures")

    def __init__(self) -> None:
        self.failures = 0
        self.failed_at = 0.0

    @property
    def delay(self) -> float:
        """Seconds after the last failure without another attempt."""
        excess = self.failures - _FREE
        return 0.0 if excess <= 0 else min(_FIRST * 2.0 ** min(excess - 1, 10), _MAX_DELAY_S)


@final
class GuessDelays:
    """The delays of the last 1,000 guessers.

    After three wrong secrets each further one delays the next attempts: by half a second at first, twice as long each
    time, at most eight seconds. Ten minutes after the last one all are forgotten.
    """

    def __init__(self) -> None:
        self._guesses: BoundedMap[str, _Guesses] = BoundedMap(_MAX_HOSTS)

    def __len__(self) -> int:
        return len(self._guesses)

    def until(self, guesser: str) -> float:
        """Return when the next attempt is allowed; may be in the past."""
        guess = self._guesses.get(guesser)
        return 0.0 if guess is None else guess.failed_at + guess.delay

    def failed(self, guesser: str, now: float) -> tuple[int, float]:
        """Record a wrong secret; return the number of them, and the delay of the next attempt."""
        guesses = self._guesses.get(guesser)
        if guesses is None or guesses.failed_at < now - _FORGOTTEN:
            guesses = _Guesses()
        self._guesses[guesser] = guesses
        guesses.failed_at = now
        guesses.failures += 1
        return guesses.failures, guesses.delay


@final
class Authentication:
    """Checks user name and password; never shows them.

    Args:
        credentials: Passwords by user name; None or empty admits everyone.
    """

    __slots__ = ("_digests", "_key")

    def __init__(self, credentials: Mapping[str, str] | None = None) -> None:
        self._key = secrets.token_bytes(32)
        self._digests = {user: self._digest(password.encode()) for user, password in (credentials or {}).items()}

    @property
    def required(self) -> bool:
        """True if a password is required."""
        return bool(self._digests)

    def check(self, username: str | None, password: bytes | None) -> ReasonCode:
        """Return success, 0x87 if nothing was presented, or 0x86.

        The check takes equally long for unknown users and for any password.
        """
        if not self._digests:
            return ReasonCode.SUCCESS
        if username is None:
            return ReasonCode.NOT_AUTHORIZED
        known = self._digests.get(username)
        right = hmac.compare_digest(known or _NOBODYS, self._digest(password or b""))
        if right and known is not None:
            return ReasonCode.SUCCESS
        return ReasonCode.BAD_USER_NAME_OR_PASSWORD

    def _digest(self, password: bytes) -> bytes:
        return hmac.digest(self._key, password, "sha256")


_MAX_KNOWN: Final = 2000
_LONG: Final = 16  # bytes of a password too long to guess


class Applicant(NamedTuple):
    """A client that asks to log in."""

    host: str
    username: str | None
    client_id: str


@final
class LoginThrottle:
    """The delays of login attempts, by host: see :class:`homebot.support.guess_delays.GuessDelays`.

    A client that has logged in from there before does not wait until its password is wrong once; with a long password
    it never waits, because guessers may use its name. The numbers of remembered hosts and clients are bounded; the
    least recent are forgotten first.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._guessers = GuessDelays()
        self._known: BoundedMap[Applicant, bool] = BoundedMap(_MAX_KNOWN)  # whether it has been right since

    def __len__(self) -> int:
        return len(self._guessers)

    def until(self, applicant: Applicant, right: bytes) -> float:
        """Return when the attempt may be checked, on the monotonic clock; may be in the past.

        Args:
            right: Its password if correct, otherwise empty.
        """
        was_right = self._known.get(applicant)
        if was_right or (was_right is not None and len(right) >= _LONG):
            return 0.0
        return self._guessers.until(applicant.host)

    def failed(self, applicant: Applicant) -> tuple[int, float]:
        """Record a wrong password; return the number from this host, and the delay of its next attempt."""
        if applicant in self._known:
            self._known[applicant] = False
        return self._guessers.failed(applicant.host, self._clock.monotonic())

    def succeeded(self, applicant: Applicant) -> None:
        """Record a correct password."""
        self._known[applicant] = True


@final
class WaitingLogins:
    """The connections that have not logged in yet, oldest first.

    Beyond the limit the host with the most loses its oldest one, so that a flood from one host
    does not keep others out.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._candidates: dict[ConnectedClient, None] = {}

    def __len__(self) -> int:
        return len(self._candidates)

    def __iter__(self) -> Iterator[ConnectedClient]:
        return iter(self._candidates)

    def add(self, candidate: ConnectedClient) -> None:
        """Add an opened connection."""
        if len(self._candidates) >= self._most:
            hosts = [host_of(candidate.address) for candidate in self._candidates]
            most = Counter(hosts).most_common(1)[0][0]
            oldest = next(client for client, host in zip(self._candidates, hosts, strict=True) if host == most)
            del self._candidates[oldest]
            oldest.make_room()
        self._candidates[candidate] = None

    def discard(self, candidate: ConnectedClient) -> None:
        """Remove a connection that has logged in or closed."""
        self._candidates.pop(candidate, None)


def host_of(address: str) -> str:
    """Return the host of ``HOST:PORT``; of IPv6, the part that belongs to one owner."""
    return network_of(address.rpartition(":")[0])
