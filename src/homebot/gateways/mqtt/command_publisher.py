"""Commands on their way to devices: written by their convention, checked, and published."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from hashlib import blake2b
from secrets import token_bytes
from typing import Final

from homebot.conventions.description import Publication, TakesCode
from homebot.devices.gateway_messages import Command
from homebot.errors import HomebotError, LinkError, RefusedError, UnableError, WrongCodeError
from homebot.gateways.announced.announcement import AnnouncedPart
from homebot.gateways.announced.engine import GatewayEngine
from homebot.gateways.mqtt.responses import Responses
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.packets import NO_PROPERTIES, Properties, ReasonCode
from homebot.mqtt.topics import validate_topic
from homebot.support.bounded_map import BoundedMap

__all__ = ["CommandPublisher", "SentSecrets"]

MAX_SECRETS = 1_000
"""Topics of which the last secret is known; then the oldest is forgotten."""

_LEAST_QOS: Final = 1
"""Of commands, so that the broker says that it has them."""


class SentSecrets:
    """The last message with a code on each topic, as a keyed hash; the code itself is not kept."""

    def __init__(self) -> None:
        self.sent: BoundedMap[str, bytes] = BoundedMap(MAX_SECRETS)
        self._key = token_bytes(32)

    def record(self, publication: Publication) -> Publication:
        """Record *publication*, and return it as it may be sent: not retained, as it has a code."""
        self.sent[publication.topic] = self._hash(publication.payload)
        return publication._replace(retain=False)

    def is_one(self, topic: str, payload: bytes) -> bool:
        """Return whether a message is one that we sent with a code."""
        return self.sent.get(topic) == self._hash(payload)

    def _hash(self, payload: bytes) -> bytes:
        return blake2b(payload, key=self._key, digest_size=32).digest()


class CommandPublisher:
    """The way from commands to publications."""

    def __init__(
        self,
        engine: GatewayEngine[MqttMessage],
        connection: MqttConnection,
        secrets: SentSecrets,
        responses: Responses | None = None,
    ) -> None:
        self._find_part, self._quarantine = engine.find_part, engine.quarantine
        self._connection = connection
        self._secrets = secrets
        self._responses = responses

    async def perform(self, command: Command) -> None:
        """Publish *command*; return when the broker has it. A broker that speaks MQTT 5 forgets it when it expires.

        Any other keeps a message of QoS 1 or 2 for a device that is away until that is back, and so a repetition has
        QoS 0: the device obeys once then.

        Raises:
            UnableError: No part is described that can do that; nothing was sent.
            RefusedError: The code is wrong, or the broker refused.
            LinkError: There is no link; or the part reports nothing that could show whether it obeyed, and no client
                subscribes to the topic, as far as an MQTT 5 broker says so, or the broker has just come back and the
                device was not heard since.
        """
        try:
            announced_part = self._find_part(command.key, command.part)
            publications = self._written(announced_part, command)
        except WrongCodeError:
            raise  # no other way to the part is tried with a wrong code: it might ask for none
        except HomebotError as exc:
            raise UnableError(str(exc)) from exc
        reports = partial(announced_part.reports, command.capability)
        await self._connection.require_peer(announced_part.stored.heard_at, reports)
        if command.code:
            publications = tuple(self._secrets.record(one) for one in publications)
        is_heard = await self._publish(command, publications)
        if publications and not is_heard and not reports():
            raise LinkError(f"no client subscribes to {publications[0].topic[:100]}")

    async def _publish(self, command: Command, publications: Iterable[Publication]) -> bool:
        """Publish the messages of *command*; return whether a client may have received one, or will."""
        properties = _expiring(command)
        if self._responses is not None:
            properties = self._responses.request(command, properties)
        is_unkept = command.repeated and not self._connection.expires_messages
        publish, is_heard = self._connection.publish, False
        for one in publications:
            qos = 0 if is_unkept else max(one.qos, _LEAST_QOS)
            reason = await publish(one.topic, one.payload, qos=qos, retain=one.retain, properties=properties)
            is_heard = is_heard or reason != ReasonCode.NO_MATCHING_SUBSCRIBERS or one.retain
        return is_heard

    def _written(self, announced_part: AnnouncedPart, command: Command) -> tuple[Publication, ...]:
        name, value, codec = command.capability, command.value.plain(), announced_part.described.codec
        if command.code and not isinstance(codec, TakesCode):
            raise RefusedError(f"{name} of {command.key[:100]}", "it takes no code")
        try:
            if command.code and isinstance(codec, TakesCode):
                publications = tuple(codec.write_with_code(name, value, command.code))
            else:
                publications = tuple(codec.write(name, value, transition=command.transition))
        except RefusedError:
            raise
        except BaseException as exc:  # recorded as its failure; a plug-in's fault must not be everybody's
            announced = announced_part.stored.described
            self._quarantine.record_plugin_failure(announced.topic, announced.convention, exc)
            raise RefusedError(f"{name} of {command.key[:100]}", "its convention failed") from exc
        for one in publications:
            validate_topic(one.topic)
            # Only topics in the announcement were checked against other devices and reserved topics.
            if one.topic not in announced_part.described.part.writes:
                raise RefusedError(
                    f"a command to {command.key[:100]}", f"it did not announce {one.topic} as a command topic"
                )
        return publications


def _expiring(command: Command) -> Properties:
    """Return the properties of a message that expires with *command*, or before it is sent again.

    Brokers count whole seconds, and may deliver it in the last one.
    """
    seconds = command.kept_for or command.expires_after
    return Properties(message_expiry_interval=max(1, math.floor(seconds))) if seconds else NO_PROPERTIES
