"""Settings of a test's broker, and its certificate."""

import ssl
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from datetime import datetime, timedelta
from pathlib import Path
from typing import Final, Self

from homebot.errors import UsageError
from homebot.mqtt.broker import BrokerLimits
from homebot.mqtt.broker.limits import checked_keep_alive
from homebot.mqtt.certificate import load_certificate
from homebot.mqtt.topics import validate_filter
from homebot.support.names import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokerSettings:
    """The arguments of the mark ``mqtt_broker``, checked where they are made.

    Attributes:
        user: Allowed user; None allows everybody.
        password: Of that user; never shown.
        tls: Speak TLS, with a certificate for 127.0.0.1, ::1 and localhost.
        keep_alive: The longest keep-alive of an MQTT 5 client in seconds, 1 to 65535; None leaves it to them.
        refuse_filter: One or several filters with subscriptions answered by 0x80.
        limits: The broker's bounds.
        allow_protocol_errors: Whether clients may break the protocol without failing the test.

    Raises:
        UsageError: An argument is of the wrong type, out of its range or contradicts another.
    """

    user: str | None = None
    password: str | None = None
    tls: bool = False
    keep_alive: int | None = None
    refuse_filter: str | Collection[str] = ()
    limits: BrokerLimits | None = None
    allow_protocol_errors: bool = False

    def __post_init__(self) -> None:
        """Check everything: a mark is written by hand, and no type checker sees it."""
        for name in ("user", "password"):
            _check(name, getattr(self, name), str | None, "text", secret=name == "password")
        if (self.user is None) != (self.password is None):
            raise UsageError("user and password go together")
        for name in ("tls", "allow_protocol_errors"):
            _check(name, getattr(self, name), bool, "True or False")
        if self.keep_alive is not None:
            _check("keep_alive", self.keep_alive, int, "a whole number of seconds")
            checked_keep_alive(self.keep_alive)
        _check("limits", self.limits, BrokerLimits | None, "a BrokerLimits")
        _check("refuse_filter", self.refuse_filter, str | Collection, "a topic filter or a list of them")
        for refused in self.refused_filters:
            _check("refuse_filter", refused, str, "a topic filter or a list of them")
            validate_filter(refused)

    def __repr__(self) -> str:
        shown = (
            f"{field.name}={'...' if field.name == 'password' else repr(getattr(self, field.name))}"
            for field in fields(self)
            if getattr(self, field.name) != field.default
        )
        return f"BrokerSettings({', '.join(shown)})"

    @classmethod
    def parse(cls, arguments: Mapping[str, object]) -> Self:
        """Create them from unchecked keyword arguments.

        Raises:
            UsageError: There is no such argument; names the one that was probably meant. Also as above.
        """
        known = [field.name for field in fields(cls)]
        for name in arguments:
            if name not in known:
                hint = did_you_mean(name, known, f"there are: {', '.join(known)}")
                raise UsageError(f"there is no argument {name!r}; {hint}")
        return cls(**arguments)  # type: ignore[arg-type] # checked by __post_init__

    @property
    def credentials(self) -> dict[str, str] | None:
        """Passwords by user name, as the broker takes them."""
        return None if self.user is None or self.password is None else {self.user: self.password}

    @property
    def refused_filters(self) -> tuple[str, ...]:
        """All filters to refuse."""
        return (self.refuse_filter,) if isinstance(self.refuse_filter, str) else tuple(self.refuse_filter)


def _check(name: str, value: object, kind: object, text: str, *, secret: bool = False) -> None:
    wrong = not isinstance(value, kind) or (kind is int and isinstance(value, bool))  # type: ignore[arg-type] # a union
    if wrong:
        raise UsageError(f"{name} is {text}{'' if secret else f', not {value!r}'}")


_VALID: Final = timedelta(days=30)  # a test run, however long, on a computer with a wrong clock


@dataclass(frozen=True, slots=True)
class TestTls:
    """A certificate for 127.0.0.1, ::1 and localhost."""

    __test__ = False  # not a test class in spite of its name

    ca_file: Path
    context: ssl.SSLContext

    @classmethod
    def make(cls, folder: Path, now: datetime) -> Self:
        """Create new keys and write the files of clients and server into *folder*.

        Args:
            now: In UTC; the certificate is valid from a day before to thirty days after.

        Raises:
            ImportError: The package trustme is not installed.
        """
        try:
            import trustme  # noqa: PLC0415 - loads 60 modules that only tests with TLS need
        except ModuleNotFoundError as exc:
            if exc.name != "trustme":
                raise
            raise ImportError("a test broker with TLS needs trustme: pip install 'homebot[testing]'") from exc
        authority = trustme.CA(organization_name="homebot tests")
        server = authority.issue_cert(
            "localhost",
            "127.0.0.1",
            "::1",
            common_name="localhost",
            not_before=now - timedelta(days=1),
            not_after=now + _VALID,
        )
        ca_file, server_file = folder / "ca.pem", folder / "server.pem"
        authority.cert_pem.write_to_path(ca_file)
        server_file.touch(mode=0o600)
        server.private_key_and_cert_chain_pem.write_to_path(server_file)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        load_certificate(context, server_file, None, what="test certificate", key_option="key_file")
        return cls(ca_file, context)
