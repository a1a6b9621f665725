"""The settings of the rosbridge server: address, access and limits of clients."""

import re
from collections.abc import Mapping
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Final, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, SecretStr, model_validator

from homebot.bridges.admission import AccessSettings, Count
from homebot.config import value_errors
from homebot.devices.client_rights import ALL_RIGHTS, ALL_ROBOTS, LOCAL_CLIENT, OWNER_CLIENT, ClientRights
from homebot.errors import UsageError
from homebot.support.addresses import is_loopback
from homebot.units import Seconds

if TYPE_CHECKING:
    from homebot.devices.robot_owners import RobotOwners

_NAME: Final = re.compile(r"[A-Za-z0-9_-]{1,64}")


def check_token_name(name: str) -> None:
    """Check that a token can have this *name*.

    Raises:
        UsageError: It cannot.
    """
    if not _NAME.fullmatch(name) or name in {LOCAL_CLIENT, OWNER_CLIENT}:
        raise UsageError(
            f"a token cannot be called {name[:64]!r}: use letters, digits, - and _, but not {LOCAL_CLIENT} or "
            f"{OWNER_CLIENT}"
        )


def read_scope(scope: tuple[str, ...]) -> ClientRights:
    """Return the rights by :func:`homebot.words.rights.read_scope`."""
    from homebot.words import rights  # noqa: PLC0415 - few clients have a scope

    return rights.read_scope(scope)


def _check(scope: tuple[str, ...]) -> tuple[str, ...]:
    with value_errors():
        read_scope(scope)
    return scope


Scope: TypeAlias = Annotated[tuple[str, ...], AfterValidator(_check)]
"""Rights, as parsed by :func:`homebot.words.rights.read_scope`."""


class ClientToken(BaseModel):
    """The token of one program.

    Attributes:
        token: The token of the program.
        scope: Its rights.
        until: When it ends, in seconds since 1970.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    token: Annotated[SecretStr, Field(min_length=1)]
    scope: Scope
    until: float = inf


class RosbridgeSettings(AccessSettings):
    """The settings of the rosbridge server.

    If there is a ``token``, or others can reach the ``host``, every client must send one of the tokens. Of 64 clients,
    one token has at most 48 from one address, and two are kept for the right ``manage``.

    Attributes:
        tokens: Tokens of single programs by name. The ``token`` has every right.
        tls: Whether it listens with TLS, by a local authority that is made once (docs/page.md#tls).
        certificate: File with the owner's certificate, and those between it and a known authority, for TLS (PEM).
        key: File with its key, if that is not in the same file.
        scope: Rights of a client without a token. By default ``read`` and what is known to be harmless.
        max_frame_bytes: Largest frame from a client; a larger one closes its connection. A frame has at most 20,000
            values, plus a million numbers in long lists.
        max_arriving_bytes_of_all: Most bytes of frames from all clients together that are incomplete or not handled;
            then the client with the most is cut off.
        queue_depth: Most messages of one topic waiting for a slow client (on a keyed topic: of each key); then the
            oldest is dropped and counted.
        max_waiting_bytes: Most bytes of messages waiting for one slow client; then the oldest message of the topic with
            a new one is dropped and counted.
        max_waiting_bytes_of_all: Most bytes of messages waiting for all clients together; then the client with the most
            loses its oldest.
        max_kept_bytes_of_all: Most bytes of latched messages of all clients together; then the client with the most
            loses its oldest.
        max_entities: Most topics and services of one client at a time; each id of a request counts.
        max_entities_of_all: Most topics and services of all clients together.
        max_frames_per_second: Average rate of frames per client; one that sends more is read more slowly.
        stall_timeout: Seconds after which a client that does not read is cut off.
        max_calls: Most concurrent service calls, and goals, of one client; one more fails at once.
        ping_interval: Seconds between pings to a client while it has a goal or lease.
        ping_timeout: Seconds without a sign of life after a ping until a client is cut off.
    """

    port: Annotated[int, Field(ge=0, le=65535)] = 9090
    tokens: Mapping[str, ClientToken] = Field(default_factory=dict)
    tls: bool = False
    certificate: Path | None = None
    key: Path | None = None
    scope: Scope | None = None
    max_frame_bytes: Count = 6_291_456
    max_arriving_bytes_of_all: Count = 33_554_432
    queue_depth: Count = 1000
    max_waiting_bytes: Count = 8_388_608
    max_waiting_bytes_of_all: Count = 33_554_432
    max_kept_bytes_of_all: Count = 67_108_864
    max_entities: Count = 1000
    max_entities_of_all: Count = 10_000
    max_frames_per_second: Count = 1000
    max_calls: Count = 100
    stall_timeout: Seconds = 60.0
    ping_interval: Seconds = 0.4
    ping_timeout: Seconds = 2.6  # a robot pauses for a second, as its radio roams or its computer swaps

    @model_validator(mode="after")
    def _check_tokens(self) -> Self:
        if self.key is not None and self.certificate is None:
            raise ValueError("key is that of a certificate; state certificate too")
        for name in self.tokens:
            with value_errors():
                check_token_name(name)
        by_secret: dict[str, str] = {}
        for name, token in self.all_tokens().items():
            if (other := by_secret.setdefault(token.get_secret_value(), name)) != name:
                raise ValueError(f"the tokens {other} and {name} are the same; each needs a secret of its own")
        return self

    def all_tokens(self, owner: SecretStr | None = None) -> Mapping[str, SecretStr]:
        """Return all tokens by name; the name of ``token``, or else of that of the *owner*, is ``owner``."""
        named = {name: settings.token for name, settings in self.tokens.items()}
        own = self.token or owner
        return named if own is None else {OWNER_CLIENT: own, **named}

    def is_for_owner(self, secret: str) -> bool:
        """Return whether there is no token but that of the owner, *secret*."""
        return not self.tokens and (self.token is None or self.token.get_secret_value() == secret)

    def check_port(self) -> None:
        """Check that a port that was stated can be listened on.

        Raises:
            UsageError: It cannot.
        """
        if "port" in self.model_fields_set and (problem := self.why_not_free("--door or [door] port")):
            raise UsageError(f"door: {problem}")

    @property
    def has_tls(self) -> bool:
        """True if it listens with TLS."""
        return self.tls or self.certificate is not None

    def page(self, port: int) -> str:
        """Return the address of the page on *port*."""
        return f"http{'s' * self.has_tls}://{f'[{self.host}]' if ':' in self.host else self.host}:{port}"

    def robots(self) -> tuple[str, ...]:
        """Return the names of all robots that tokens may represent."""
        named = (robot for settings in self.tokens.values() for robot in read_scope(settings.scope).robots)
        return tuple(dict.fromkeys(robot for robot in named if robot != ALL_ROBOTS))

    def robot_owners(self, tables: Mapping[str, tuple[str, ...]] = MappingProxyType({})) -> "RobotOwners":
        """Return the robots that tokens may represent or that have *tables*, with their topics and frames."""
        from homebot.devices.robot_owners import RobotOwners  # noqa: PLC0415 - with the first client

        return RobotOwners(tables, self.robots())

    def rights(self, local: ClientRights, *, has_owner: bool = False) -> Mapping[str, ClientRights]:
        """Return the rights of clients by name; without ``local`` if every client must send a token."""
        rights = {name: read_scope(settings.scope) for name, settings in self.tokens.items()}
        if has_owner or self.token is not None:
            rights[OWNER_CLIENT] = ALL_RIGHTS
        if self.token is None and (is_loopback(self.host) or not self.tokens):
            rights[LOCAL_CLIENT] = local if self.scope is None else read_scope(self.scope)
        return rights
