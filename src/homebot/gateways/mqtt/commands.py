"""Brings commands to devices."""

from __future__ import annotations

from homebot.conventions.description import Publication, TakesCode
from homebot.devices.command import Command, SendCommandResponse
from homebot.devices.text.encode import decode_command
from homebot.devices.value import PlainValue
from homebot.errors import HomebotError, LinkError, RefusedError, WrongCodeError
from homebot.gateways.base import Gateway
from homebot.gateways.mqtt.announcement import AnnouncedPart
from homebot.gateways.mqtt.counters import GatewayCounters
from homebot.gateways.mqtt.quarantine import PeerQuarantine
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.gateways.mqtt.sent_secrets import SentSecrets
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.topics import validate_topic

__all__ = ["CommandServer"]


class CommandServer:
    """The way from commands to publications.

    Args:
        claims: Who can be told.
        connection: Where it is published.
        tribunal: Judges conventions that fail.
        counters: Of the gateway.
        reserved: The topics on which no device is told anything.
        secrets: Knows what was sent with a code.
        gateway: Says whether anything is sent at all.
    """

    def __init__(
        self,
        claims: AnnouncementRegistry,
        connection: MqttConnection,
        tribunal: PeerQuarantine,
        counters: GatewayCounters,
        reserved: ReservedTopics,
        secrets: SentSecrets,
        gateway: Gateway,
    ) -> None:
        self._claims = claims
        self._connection = connection
        self._tribunal = tribunal
        self._counters = counters
        self._reserved = reserved
        self._secrets = secrets
        self._gateway = gateway

    async def serve(self, command: Command) -> SendCommandResponse:
        """Answer the service: send *command*, and say what became of it when the broker has it."""
        is_able = True
        try:
            self._permit(command.key)
            is_able = False
            voice = self._voice(command.key, command.part)
            value = command.value.plain()
            publications = self._written(voice, command.capability, value, command.transition, command.code)
            is_able = True
            if command.code:
                publications = tuple(self._secrets.keep(one) for one in publications)
            await self._publish(publications)
        except LinkError as exc:
            self._counters.commands_failed += 1
            return SendCommandResponse(success=False, message=str(exc), problem="unreachable")
        except HomebotError as exc:
            self._counters.commands_refused += 1
            # No other way to the part is tried with a wrong code: it might ask for none.
            is_able = is_able or isinstance(exc, WrongCodeError)
            return SendCommandResponse(success=False, message=str(exc), problem="refused", unable=not is_able)
        self._counters.commands += 1
        return SendCommandResponse(success=True)

    async def tell(self, key: str, part_id: str, said: str) -> None:
        """Tell a part the word *said*; see :mod:`homebot.devices.text.encode`.

        Raises:
            RefusedError: Nobody is described by that key and part, it does not take that word, the gateway only
                observes, or the broker said no.
            LinkError: There is no link.
        """
        self._permit(key)
        voice = self._voice(key, part_id)
        await self._publish(self._written(voice, *decode_command(said, voice.described.part), 0.0))

    def _permit(self, key: str) -> None:
        if not self._gateway.acts:
            raise RefusedError(f"a command to {key[:100]}", self._gateway.observes_because)

    def _voice(self, key: str, part_id: str) -> AnnouncedPart:
        what = f"a command to {key[:100]}"
        claim = self._claims.get(key)
        if claim is None:
            raise RefusedError(what, "no device is announced by that key")
        voice = claim.parts.get(part_id)
        if voice is None:
            known = ", ".join(repr(one) for one in sorted(claim.parts)[:10])
            raise RefusedError(what, f"it has no part {part_id[:100]!r}; it has {known}")
        return voice

    async def _publish(self, publications: tuple[Publication, ...]) -> None:
        for one in publications:
            await self._connection.publish(one.topic, one.payload, qos=one.qos, retain=one.retain)

    def _written(
        self, voice: AnnouncedPart, capability: str, value: PlainValue, transition: float, code: str = ""
    ) -> tuple[Publication, ...]:
        codec = voice.described.codec
        if code and not isinstance(codec, TakesCode):
            raise RefusedError(f"{capability} of {voice.claim.key[:100]}", "it takes no code")
        try:
            if isinstance(codec, TakesCode) and code:
                publications = tuple(codec.write_with_code(capability, value, code))
            else:
                publications = tuple(codec.write(capability, value, transition=transition))
        except RefusedError:
            raise
        except BaseException as exc:  # told by the tribunal; a plug-in's fault must not be everybody's
            self._tribunal.record_plugin_failure(voice.claim.described.topic, voice.claim.described.convention, exc)
            raise RefusedError(f"{capability} of {voice.claim.key[:100]}", "its convention failed") from exc
        for one in publications:
            self._check_topic(voice, one.topic)
        return publications

    def _check_topic(self, voice: AnnouncedPart, topic: str) -> None:
        """Refuse what the announcement did not name, because that alone was held against other devices."""
        validate_topic(topic)
        if topic not in voice.described.part.writes:
            raise RefusedError(f"a command to {voice.claim.key[:100]}", f"it was not announced to listen on {topic}")
        if why := self._reserved.why(topic, voice.claim.described.convention):
            raise RefusedError(f"a command to {voice.claim.key[:100]}", f"{topic} is not for devices: {why}")
