"""View of a broker for a test, without waiting."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.core import BrokerCore, ClientView
from homebot.testing.mqtt.packet_log import PacketLog
from homebot.testing.mqtt.protocol_violation import ProtocolViolation
from homebot.testing.mqtt.settings import BrokerSettings
from homebot.testing.mqtt.thread import BrokerThread

__all__ = ["BrokerView"]


class BrokerView:
    """The base of both kinds of brokers that fixtures give."""

    __test__ = False  # no collection of tests, whatever the name

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        self._core = core
        self._thread = thread

    @property
    def host(self) -> str:
        """The loopback address it listens on."""
        return self._core.broker.host

    @property
    def port(self) -> int:
        """The TCP port; stays the same over :meth:`restart`."""
        return self._core.broker.port

    @property
    def url(self) -> str:
        """Such as ``mqtt://127.0.0.1:34567``; ``mqtts`` with TLS."""
        return self._core.broker.url

    @property
    def ca_file(self) -> Path | None:
        """PEM file of the authority that clients are to trust; None without TLS."""
        return self._core.ca_file

    @property
    def settings(self) -> BrokerSettings:
        """Settings that the test asked for."""
        return self._core.settings

    @property
    def clients(self) -> Mapping[str, ClientView]:
        """The clients the broker knows now by their ids; those away too, while their session is kept."""
        return self._core.clients

    @property
    def packet_log(self) -> PacketLog:
        """The newest packets, which pytest prints when the test fails."""
        return self._core.log

    @property
    def protocol_errors(self) -> tuple[ProtocolViolation, ...]:
        """Violations of MQTT by clients, in their order; the first 20, those that a fault led to left out."""
        return self._core.breaches.kept

    def forget_protocol_errors(self) -> None:
        """Forget them: they were what the test is about."""
        self._core.breaches.clear()

    def forget_messages(self) -> None:
        """Forget what clients have published so far; for a broker that several tests share."""
        self._core.journal.clear()

    def assert_not_published(self, filter: str) -> None:  # noqa: A002 - the protocol's own word
        """Make sure that no client has published on *filter*, messages taken by ``expect`` aside.

        Call ``settle`` first: this looks only at what the broker has got.

        Raises:
            AssertionError: One has; shows the messages.
            InvalidNameError: *filter* is no topic filter.
        """
        validate_filter(filter)
        came = self._core.journal.waiting(filter)
        if came:
            __tracebackhide__ = True  # pytest then points at the test's line
            raise AssertionError("\n".join([f"{len(came)} published on {filter}:", *(f"    {each}" for each in came)]))
