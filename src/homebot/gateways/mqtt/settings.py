"""The table ``[gateways.NAME]`` of an MQTT gateway."""

import json
import os
import secrets
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Self

from pydantic import ConfigDict, Field, ValidationError, ValidationInfo, field_validator, model_validator

from homebot.config import FilePath, PeerAddress, SecretFile, value_errors
from homebot.conventions.installed_conventions import any_announcing, check_tables, default_conventions
from homebot.errors import UsageError
from homebot.gateways.announced.registry import MAX_MEMORY
from homebot.gateways.base import Delivery
from homebot.gateways.password_settings import PasswordSettings, check_secret_file
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import MqttClientName
from homebot.mqtt.options import MqttOptions, MqttProtocol
from homebot.mqtt.topics import validate_topic
from homebot.units import DURATION, Seconds

EMBEDDED = "embedded"

USUAL_PORTS = (*range(1883, 1903), 0)
"""Ports that the embedded broker tries; 0 is any free one."""


def embedded_ports(url: str) -> tuple[int, ...] | None:
    """Return the ports that the embedded broker may have by *url*; None for another broker.

    Raises:
        UsageError: It names no port from 1 to 65535.
    """
    name, _, port = url.partition(":")
    if name != EMBEDDED:
        return None
    if url == EMBEDDED:
        return USUAL_PORTS
    if not (port.isdecimal() and port.isascii() and 1 <= int(port[:6]) <= 65535):
        raise UsageError(f"the port of {url!r} is no whole number from 1 to 65535")
    return (int(port),)


RECEIVE_MAXIMUM = 2048
"""Messages that may wait for our acknowledgement.

Together with the 1,000 that Mosquitto queues by default, this is how many retained messages the first subscription
receives without loss.
"""

INBOX_MESSAGES = 100_000
INBOX_BYTES = 64 * 1024 * 1024
"""Bytes for the announcements of a house, which the broker sends all at once; it drops what stays queued."""


class MqttGatewaySettings(PasswordSettings):
    """The settings of the MQTT gateway: its broker, and its treatment of messages.

    Attributes:
        url: ``mqtt://[user[:password]@]host[:port]``, ``mqtts://…``, or ``embedded[:port]`` for homebot's own broker,
            by default on the first free port of 1883 to 1902.
        root: The home: first level of its topics. If it is empty, announced devices of all homes are found, and
            devices of plain text of the home with the name in ``[home]``.
        delivery: ``inbox`` puts raw messages into the one inbox of each node that asked for them; ``mirror`` gives each
            device a topic ``/gateway/NAME/received_data/<device>``.
        act: Whether commands are sent; false observes only. By default true for the embedded broker alone.
        user: Login name.
        ca_file: PEM file of the authorities to trust with ``mqtts``.
        cert_file: PEM file of this client's certificate.
        key_file: PEM file of its key.
        client_id: Name at the broker, unique there; by default a new one for each run, which ends the session. A
            fixed one gets the messages that the broker queued while homebot was not running.
        client: ``aiomqtt``, proven with most brokers, or ``native``, homebot's own, which needs less CPU time. By
            default the latter on the embedded broker, the former on all others. aiomqtt sends QoS 2 as QoS 1, so a
            message may arrive twice.
        protocol: ``auto`` tries MQTT 5 and falls back to 3.1.1, also if a broker does not answer 5 for 10 s; or one
            of ``5`` and ``3.1.1``.
        max_payload: Largest message in bytes; the broker is informed, larger ones are dropped and counted.
        max_announcement: The same for lists of devices: Zigbee2MQTT's needs about 4 kB for each, so the default is
            enough for 5,000. A device's own announcement is refused above 256 kB. An MQTT 5 broker silently drops a
            larger list: ``homebot doctor`` then reports a bridge without one; with 3.1.1 it is counted as ``dropped
            oversize``.
        max_memory: Estimated bytes for announced devices in gateway and directory; further announcements are refused
            with a warning. The default is enough for 30,000 devices; 64 MiB (67108864) do for 500.
        session_expiry: Seconds for which the broker queues messages while the gateway is disconnected.
        stale_after: Seconds of silence after which a device counts as stale.
        responses: Whether commands ask the devices for a response, where the broker speaks MQTT 5.
        conventions: Conventions to understand, by entry-point name or ``module:Class``; by default all that
            come with homebot.
        share: The group of gateways, here or elsewhere, that share the texts of devices (``$share`` of MQTT 5): each
            message goes to one of them, so they observe, and discover nothing by announcements.

    A further key is the name of a convention, with that convention's own table, see :attr:`tables`.
    """

    model_config = ConfigDict(frozen=True, extra="allow", defer_build=True)

    url: PeerAddress = EMBEDDED
    root: str = ""
    delivery: Delivery = "inbox"
    act: bool | None = None
    user: str | None = None
    ca_file: FilePath | None = None
    cert_file: FilePath | None = None
    key_file: SecretFile | None = None
    client_id: str = Field(
        default_factory=lambda: f"homebot-{secrets.token_hex(4)}",
        repr=False,  # it takes over the session at a broker without passwords
    )
    client: MqttClientName | None = None
    protocol: MqttProtocol = "auto"
    max_payload: Annotated[int, Field(ge=1024, lt=2**28)] = 256 * 1024
    max_announcement: Annotated[int, Field(ge=1024, lt=2**28)] = 32 * 1024 * 1024
    max_memory: Annotated[int, Field(ge=1024 * 1024, lt=2**40)] = MAX_MEMORY
    session_expiry: Annotated[int, DURATION, Field(ge=0, lt=2**32)] = 3600
    stale_after: Seconds = 3600.0
    responses: bool = False
    conventions: tuple[str, ...] = Field(default_factory=default_conventions)
    share: str = ""

    @property
    def embedded(self) -> tuple[int, ...] | None:
        """The ports of :func:`embedded_ports`."""
        return embedded_ports(self.url)

    @property
    def tables(self) -> dict[str, object]:
        """The tables of conventions, by their names."""
        return self.model_extra or {}

    @field_validator("url")
    @classmethod
    def _check_url(cls, url: str) -> str:
        with value_errors():
            if embedded_ports(url) is None:
                MqttOptions.from_url(url)
        return url

    @field_validator("root")
    @classmethod
    def _check_root(cls, root: str) -> str:
        if root:
            if not {"#", "+"}.isdisjoint(root):
                raise ValueError(f"must not contain '#' or '+', which are wildcards in topic filters, got {root!r}")
            with value_errors():
                validate_topic(root)
            if "" in root.split("/"):
                raise ValueError("has an empty level: write it without a / at either end")
        return root

    @field_validator("share")
    @classmethod
    def _check_share(cls, share: str, info: ValidationInfo) -> str:
        if not {"/", "+", "#", "\0"}.isdisjoint(share):
            raise ValueError(f"is one level of a topic filter, without '/', '+' and '#', got {share!r}")
        if share and any_announcing(info.data.get("conventions", ())):
            texts = json.dumps([convention for convention in default_conventions() if not any_announcing([convention])])
            raise ValueError(f"an announcement would reach one of the group alone; add conventions = {texts}")
        if share and info.data.get("act"):
            raise ValueError("needs act = false: the report after a command may reach another of the group")
        if share and info.data.get("protocol") == "3.1.1":
            raise ValueError('needs MQTT 5: leave out protocol = "3.1.1"')
        return share

    @model_validator(mode="after")
    def _check_tables(self) -> Self:
        if problems := check_tables(self.conventions, self.tables):
            raise ValidationError.from_exception_data(type(self).__name__, problems)
        return self

    def text_subscriptions(self, filters: Iterable[str]) -> tuple[MqttSubscription, ...]:
        """Return the subscriptions to the texts of devices on *filters*, shared if the gateway has a group."""
        prefix = f"$share/{self.share}/" if self.share else ""
        return tuple(
            MqttSubscription(f"{prefix}{topic_filter}", qos=1, no_local=not self.share) for topic_filter in filters
        )

    def options(self) -> MqttOptions:
        """Return the options of the client, including the password.

        Raises:
            UsageError: The password cannot be read, or the address and the settings contradict each other.
        """
        login = {"user": self.user, "password": self.read_password()}
        announcements = self.max_announcement if any_announcing(self.conventions) else 0
        return MqttOptions.from_url(
            self.url,
            ca_file=self.ca_file,
            cert_file=self.cert_file,
            key_file=self.key_file,
            client_id=self.client_id,
            protocol="5" if self.share else self.protocol,
            maximum_packet_size=max(self.max_payload, announcements),
            session_expiry=self.session_expiry,
            receive_maximum=RECEIVE_MAXIMUM,
            inbox_messages=INBOX_MESSAGES,
            inbox_bytes=INBOX_BYTES,
            session_ends_on_close="client_id" not in self.model_fields_set,
            **{name: value for name, value in login.items() if value is not None},
        )

    def with_client_id(self, client_id: str) -> "MqttGatewaySettings":
        """Return the settings with another client id, unless the user has chosen one."""
        if "client_id" in self.model_fields_set:
            return self
        return self.model_construct(_fields_set=self.model_fields_set, **(dict(self) | {"client_id": client_id}))

    def check_files(self) -> None:
        """Check that the certificate files can be read, and that only this user can read that of the key.

        Raises:
            UsageError: They cannot, or others can; the message names the setting.
        """
        for key in ("ca_file", "cert_file", "key_file"):
            file: Path | None = getattr(self, key)
            if file is None:
                continue
            try:
                with file.open("rb") as opened:
                    if key == "key_file":
                        check_secret_file(file, os.fstat(opened.fileno()))
            except OSError as exc:
                raise UsageError(f"{key}: {file} cannot be read: {exc.strerror}") from exc
            except UsageError as exc:
                raise UsageError(f"{key}: {exc}") from exc
