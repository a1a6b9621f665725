"""Commands to devices: encoded by their convention, checked and published; and the devices' responses."""

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from secrets import token_hex
from typing import Final, final

from homebot.clock import Clock
from homebot.conventions.description import AsksMembers, DeviceRequest, Publication, TakesCode, WritesSeveral
from homebot.conventions.payload import clean_text, parse_object
from homebot.devices.gateway_messages import Command, CommandAnswer
from homebot.errors import HomebotError, LinkError, RefusedError, UnableError, WireError, WrongCodeError
from homebot.gateways.announced.announcement import AnnouncedPart
from homebot.gateways.announced.engine import GatewayEngine
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.packets import NO_PROPERTIES, Properties, ReasonCode
from homebot.mqtt.topic_census import TopicCensus
from homebot.mqtt.topics import validate_topic
from homebot.support.bounded_map import BoundedMap
from homebot.support.counters import fault

COMMAND_ID: Final = "command"
"""The user property with the id of a command."""

MAX_AWAITED: Final = 1000
"""Most commands that await a response; the oldest is forgotten, and its response is then unknown."""

_TOKEN: Final = 8  # bytes, as 16 hexadecimal digits: easy to copy in scripts, hard to guess
_MAX_BYTES: Final = 4096  # bytes of a response
_MAX_REASON: Final = 200


@dataclass(slots=True)
class ResponseCounters:
    """Counters of responses.

    Attributes:
        responses_late: Responses that came after the command had expired.
        responses_unknown: Responses to no known command.
    """

    responses: int = 0
    responses_late: int = fault()
    responses_unknown: int = 0


@final
class Responses:
    """Asks devices for responses to commands, and publishes the answers.

    A command carries a response topic, and correlation data that match the two (MQTT 5.0, section 4.10).
    """

    def __init__(self, gateway: str, topic: str, clock: Clock, publish: Callable[[CommandAnswer], object]) -> None:
        self.counters = ResponseCounters()
        self.topic = topic
        self._gateway = gateway
        self._clock = clock
        self._publish = publish
        self._awaited: BoundedMap[bytes, tuple[Command, float]] = BoundedMap(MAX_AWAITED)

    def request(self, command: Command, properties: Properties) -> Properties:
        """Return *properties* for a message with *command*, with a request for a response if a caller waits for one."""
        if not command.id:
            return properties
        token = token_hex(_TOKEN).encode()
        until = self._clock.monotonic() + (command.expires_after or math.inf)
        self._awaited[token] = command, until
        return replace(self.named(command.id, properties), response_topic=self.topic, correlation_data=token)

    @staticmethod
    def named(command_id: str, properties: Properties = NO_PROPERTIES) -> Properties:
        """Return *properties* with the id of the command in the message; unchanged if that is empty."""
        return replace(properties, user_properties=((COMMAND_ID, command_id),)) if command_id else properties

    def on_response(self, message: MqttMessage) -> None:
        """Match a message on :attr:`topic` with its command, and publish the answer."""
        awaited = self._awaited.pop(message.properties.correlation_data or b"", None)
        if awaited is None or message.retain:
            self.counters.responses_unknown += 1
            return
        command, until = awaited
        if self._clock.monotonic() > until:
            self.counters.responses_late += 1
            return
        self.counters.responses += 1
        self._publish(CommandAnswer.to(command, self._gateway, problem_of(message.payload)))


def problem_of(response: bytes) -> str:
    """Return the reason given by a response that refuses a command; empty for any other response.

    No standard defines responses: one with an error, as Zigbee2MQTT and Shelly send, is a refusal; any other accepts.
    """
    try:
        fields = parse_object(response[:_MAX_BYTES])
    except WireError:
        return ""
    error = fields.get("error")
    if not (error or fields.get("status") == "error" or fields.get("success") is False):
        return ""
    text = error.get("message") if isinstance(error, dict) else error or fields.get("message")
    return clean_text(text, _MAX_REASON) if isinstance(text, str) and text.strip() else "the device refuses"


_MIN_QOS: Final = 1
"""QoS of commands, so that the broker acknowledges them."""


class CommandPublisher:
    """Publishes commands.

    Args:
        census: Its counts could hide that no client subscribes to a topic.
        ask: Asks the members of a group for their state.
    """

    def __init__(
        self,
        engine: GatewayEngine[MqttMessage],
        connection: MqttConnection,
        census: TopicCensus,
        ask: Callable[[DeviceRequest], None],
        responses: Responses | None = None,
    ) -> None:
        self._ask = ask
        self._find_part, self._quarantine = engine.find_part, engine.quarantine
        self._connection = connection
        self._census = census
        self._responses = responses

    async def perform(self, command: Command) -> Collection[str]:
        """Publish *command*; return the capabilities that it sets when the broker has it.

        An MQTT 5 broker drops the message when the command expires. Others keep a message of QoS 1 or 2 until an absent
        device is back, so repetitions have QoS 0, and the device obeys once.

        Raises:
            UnableError: No described part can do that; nothing was sent.
            RefusedError: The code is wrong, or the broker refused.
            LinkError: There is no link. Or the part has no report that could confirm the command, and an MQTT 5 broker
                says that no client subscribes to the topic.
        """
        try:
            announced_part = self._find_part(command.key, command.part, command.topics)
            publications, names = self._write(announced_part, command)
        except WrongCodeError:
            raise  # with a wrong code no other route is tried: it might not ask for one
        except HomebotError as exc:
            raise UnableError(str(exc)) from exc
        await self._connection.require_link()
        if self._census.is_counting and not any(map(announced_part.reports, names)):
            await self._census.end()
        if command.code:
            publications = tuple(
                publication._replace(retain=False) for publication in publications
            )  # no code stays on the broker
        if command.id and announced_part.described.refusal is not None:
            announced_part.sent = command, publications
        is_heard = await self._publish(command, publications)
        if announced_part.described.part.members:
            self._ask_members(announced_part, publications)
        if publications and not is_heard and not any(map(announced_part.reports, names)):
            raise LinkError(f"no client subscribes to {publications[0].topic[:100]}")
        return names

    async def refresh(self, key: str, part: str) -> None:
        """Ask a part for its values, or the members of a group, soon; see :data:`Refresh`."""
        announced_part = self._find_part(key, part)
        await self._connection.require_link()
        if not (self._ask_members(announced_part, ()) or announced_part.described.state_requests):
            raise UnableError(f"{key[:100]} answers no requests")
        for publication in announced_part.described.state_requests:
            self._ask(DeviceRequest(f"{key} {publication.topic}", (publication,)))

    def _ask_members(self, group: AnnouncedPart, sent: tuple[Publication, ...]) -> bool:
        """Ask the members of a group for the values that *sent* changes, by default for all; return whether any can."""
        codec = group.described.codec
        questions = codec.questions(sent) if isinstance(codec, AsksMembers) else ()
        for publication in questions:
            self._ask(DeviceRequest(f"{group.stored.key} {publication.topic}", (publication,)))
        return bool(questions)

    async def _publish(self, command: Command, publications: Iterable[Publication]) -> bool:
        """Publish the messages of *command*; return whether a client may receive one of them.

        They expire with the command, or before it is repeated. Brokers count whole seconds, and may still deliver a
        message in the last one.
        """
        seconds = command.kept_for or command.expires_after
        properties = Properties(message_expiry_interval=max(1, math.floor(seconds))) if seconds else NO_PROPERTIES
        if self._responses is not None:
            properties = self._responses.request(command, properties)
        is_unkept = command.repeated and not self._connection.expires_messages
        publish, is_heard = self._connection.publish, False
        for publication in publications:
            qos = 0 if is_unkept else max(publication.qos, _MIN_QOS)
            reason = await publish(
                publication.topic, publication.payload, qos=qos, retain=publication.retain, properties=properties
            )
            is_heard = is_heard or reason != ReasonCode.NO_MATCHING_SUBSCRIBERS or publication.retain
        return is_heard

    def _write(
        self, announced_part: AnnouncedPart, command: Command
    ) -> tuple[tuple[Publication, ...], Collection[str]]:
        """Return the messages of *command*, and the names of those of its settings that they set."""
        name, value, codec = command.capability, command.value.plain(), announced_part.described.codec
        if command.code and not isinstance(codec, TakesCode):
            raise RefusedError(f"{name} of {command.key[:100]}", "it takes no code")
        names: Collection[str] = (name,)
        try:
            if command.also and not command.code and isinstance(codec, WritesSeveral):
                values = {single.capability: single.value.plain() for single in command.singly()}
                publications, names = codec.write_several(values, transition=command.transition)
            elif command.code and isinstance(codec, TakesCode):
                publications = tuple(codec.write_with_code(name, value, command.code))
            else:
                publications = tuple(codec.write(name, value, transition=command.transition))
        except RefusedError:
            raise
        except BaseException as exc:  # recorded as its failure; a plug-in's fault must not be everybody's
            announced = announced_part.stored.described
            self._quarantine.record_plugin_failure(announced.topic, announced.convention, exc)
            raise RefusedError(f"{name} of {command.key[:100]}", "its convention failed") from exc
        for publication in publications:
            validate_topic(publication.topic)
            # Only the announced topics were checked against other devices and reserved topics.
            if publication.topic not in announced_part.described.part.writes:
                raise RefusedError(
                    f"a command to {command.key[:100]}", f"it did not announce {publication.topic} as a command topic"
                )
        return publications, names
