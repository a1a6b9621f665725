"""The gateway that follows one of another machine, and publishes its devices as devices here."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Final, TypeVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, SecretStr

from homebot.bridges.zenoh.current_session import CurrentSession
from homebot.config import SecretFile
from homebot.devices import RawCommand, Sighting, SubscribeToTopic
from homebot.devices.approval_messages import DescribeCommands, DescribeCommandsRequest, DescribeCommandsResponse
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import REACHABLE, Command, CommandAnswer, Report, SendCommand, SendCommandResponse
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse, Quarantine
from homebot.devices.names import ONLY_OBSERVES, PairingNames
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.value import UNKNOWN
from homebot.errors import HomebotError, LinkError, PeerError, RefusedError, UnansweredError, UsageError
from homebot.features.machine.machine_link import MachineLink
from homebot.features.machine.pending_updates import MAX_OF_EACH
from homebot.features.machine.wire import MachineWire
from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings
from homebot.gateways.pairing import Pair, PairResponse, Unpair
from homebot.gateways.password_settings import read_password
from homebot.gateways.raw_delivery import RawDelivery
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.log import LogLimit
from homebot.messages.builtin_interfaces import Time
from homebot.messages.cdr import message_from_cdr
from homebot.messages.message import Message
from homebot.names import unescape_token
from homebot.support.bounded_map import BoundedMap
from homebot.support.counters import Severity

if TYPE_CHECKING:
    from pathlib import Path

    from homebot.features.machine.messages import FollowGatewayResponse

HeardT = TypeVar("HeardT", Sighting, Report)

_MAX_LENGTH = 1000
"""Characters of a text, and elements of a list, of an announcement: the other machine need not be believed."""

_STAMPS = {Sighting: ("seen_at", "expires_at"), Report: ("received_at",)}
_SAME_TIME = 5.0
"""Seconds by which the time of day there may differ; beyond, the computer has no clock, or a wrong one."""

_NEWEST_OF_EACH = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Mirror:
    """Publisher of the devices of another gateway in the name of *gateway*.

    Attributes:
        refused: Announcements that are longer than any of a device.
    """

    def __init__(self, gateway: Gateway) -> None:
        self._gateway, self._name = gateway, gateway.node.name
        node, names = gateway.node, gateway.names
        self._clock = node.graph.clock
        self._answers = node.create_publisher(CommandAnswer, names.answers, 1000)
        self._quarantines = node.create_publisher(Quarantine, names.quarantine, _NEWEST_OF_EACH)
        self._devices: BoundedMap[str, Sighting] = BoundedMap(MAX_OF_EACH)
        self._reports: BoundedMap[str, Report] = BoundedMap(MAX_OF_EACH)
        self.refused = 0

    def publish(self, news: FollowGatewayResponse, later: float) -> None:
        """Publish *news* of a machine whose monotonic clock is *later* seconds behind the one here."""
        if news.is_whole:
            for key in self._devices.keys() - set(news.keys):
                gone = self._devices[key].model_copy(
                    update={"kind": "removed", "why": "it left while there was no link"}
                )
                self._publish_sighting(gone)
            self._dispose(self._reports.keys() - set(news.streams))
        for sighting in news.sightings:
            if _is_usual(sighting):
                self._publish_sighting(self._own(sighting, later))
            else:
                self.refused += 1
        for report in news.reports:
            self._publish_report(self._own(report, later))
        for answer in news.answers:
            self._answers.publish(answer.model_copy(update={"gateway": self._name}))
        for quarantined in news.quarantines:
            self._quarantines.publish(quarantined.model_copy(update={"gateway": self._name}))
            if quarantined.is_over:
                self._quarantines.dispose(quarantined.offender)

    def on_link_loss(self) -> None:
        """Publish of all devices that said that they can be reached that this is unknown now."""
        for report in tuple(self._reports.values()):
            if report.address and any(reading.capability == REACHABLE for reading in report.readings):
                readings = tuple(reading.model_copy(update={"value": UNKNOWN}) for reading in report.readings)
                # without an address: it is not reported any more
                self._publish_report(report.model_copy(update={"readings": readings, "address": ""}))

    def _own(self, message: HeardT, later: float) -> HeardT:
        """Return *message* as of this gateway, in the time of the clocks here."""
        own: dict[str, object] = {"gateway": self._name}
        if message.heard_at:
            now, stamps = self._clock.monotonic(), {name: getattr(message, name) for name in _STAMPS[type(message)]}
            heard_at = own["heard_at"] = max(0.0, min(now, message.heard_at + later))
            behind = self._clock.now() - (now - heard_at) - next(iter(stamps.values())).to_seconds()
            if abs(behind) > _SAME_TIME:
                own |= {name: Time.from_seconds(stamp.to_seconds() + behind) for name, stamp in stamps.items()}
        return message.model_copy(update=own)

    def _publish_sighting(self, sighting: Sighting) -> None:
        if sighting.kind == "removed":
            self._devices.pop(sighting.key, None)
            self._dispose(report.stream for report in tuple(self._reports.values()) if report.key == sighting.key)
        else:
            self._devices[sighting.key] = sighting
        self._gateway.publish_sighting(sighting)

    def _publish_report(self, report: Report) -> None:
        self._gateway.reports.publish(report)
        is_over = report.key not in self._devices or all(reading.capability in EVENTS for reading in report.readings)
        if is_over:  # nothing is kept of events, and of a device that has just left
            self._gateway.reports.dispose(report.stream)
        else:
            self._reports[report.stream] = report

    def _dispose(self, streams: Iterable[str]) -> None:
        for stream in streams:
            self._reports.pop(stream, None)
            self._gateway.reports.dispose(stream)


def _is_usual(value: object) -> bool:
    if isinstance(value, Message):
        return all(map(_is_usual, value.__dict__.values()))
    if isinstance(value, tuple):
        return len(value) <= _MAX_LENGTH and all(map(_is_usual, value))
    return not isinstance(value, str) or len(value) <= _MAX_LENGTH


NOT_SENT = "gateway.command_failed"

_AGAIN: Final = 0.5
"""Seconds between two attempts to reach the machine; one costs a third of a millisecond while it is away."""

_MENDED: Final = 10.0
"""The same while a configuration has to be mended."""

_ANSWERS_WITHIN, _PAIRS_WITHIN = 5.0, 120.0  # seconds


class MachineGatewaySettings(GatewaySettings):
    """The table ``[gateways.NAME]`` of a gateway of another machine.

    Attributes:
        machine: The name of the machine, as in its table ``[ros]``; by default the name of this gateway.
        gateway: The name of its gateway; by default its only one.
        token_file: File with the secret of both machines in its first line, readable by its owner only.
    """

    machine: str = ""
    gateway: str = ""
    token_file: SecretFile


class MachineGateway(Gateway):
    """A gateway of another machine of the house, as one of this."""

    Settings: ClassVar[type[BaseModel]] = MachineGatewaySettings

    def __init__(self, node: Node, settings: MachineGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._settings, self._may_act = settings, self.acts
        self._problem = "its machine was not reached yet"
        self._machine = settings.machine or node.name
        self._link: MachineLink | None = None
        self._mirror = Mirror(self)
        self._limit = LogLimit(node.graph.clock)
        self._listeners = RawDelivery(node, self.names, inboxes=settings.delivery == "inbox")
        node.create_task(self._listeners.watch_nodes)
        node.create_service(SendCommand, self.names.send_command, self._send, concurrent=True)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe, concurrent=True)
        node.create_service(GetHealth, self.names.health, self._health, concurrent=True)
        node.create_service(DescribeCommands, self.names.describe_commands, self._describe, concurrent=True)
        node.create_subscription(RawCommand, self.names.out, self._send_raw, 1000)
        self._pairs = False

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check the secret."""
        if isinstance(settings, MachineGatewaySettings):
            read_password(settings.token_file, None, "token")

    @classmethod
    def other_machine(cls, name: str, settings: BaseModel) -> tuple[str, Path] | None:
        """Return the machine, and the file with the secret."""
        assert isinstance(settings, MachineGatewaySettings), "the model of its table"  # noqa: S101 - for mypy
        return settings.machine or name, settings.token_file

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the gateway until cancelled, again and again."""
        try:
            while True:
                is_mistake = False
                try:
                    await self._follow(task_status)
                except HomebotError as exc:
                    self._problem, is_mistake = str(exc), isinstance(exc, UsageError)
                if self._link is not None:
                    self._link.on_loss()
                self.publish_state("unavailable", self._problem)
                self._mirror.on_link_loss()
                self.mark_ready(task_status)
                await anyio.sleep(_MENDED if is_mistake else _AGAIN)
        finally:
            if self._link is not None:
                self._link.close()

    async def _follow(self, task_status: TaskStatus[None]) -> None:
        link = self._link = self._linked()
        await link.join()
        while True:
            news = await link.news()
            self._problem = ""
            for state in news.states:
                self.acts = self._may_act and state.acts
                self.publish_state(state.state, state.reason)
            self.mark_ready(task_status)
            if news.is_whole:
                if "pair" in news.services and not self._pairs:
                    self._pairs, names = True, PairingNames(self.node.name)
                    self.node.create_service(Pair, names.pair, partial(self._pair, "pair"), concurrent=True)
                    self.node.create_service(Unpair, names.unpair, partial(self._pair, "unpair"), concurrent=True)
                for address in tuple(self._listeners.by_address):
                    self.node.create_task(partial(self._listen_again, address))
            self._mirror.publish(news, link.later)
            for raw in news.raw:
                message = raw.model_copy(update={"gateway": self.node.name})
                await self._listeners.deliver(message, wait_if_full=True)

    def _linked(self) -> MachineLink:
        """Return the link, by the session that there is now."""
        machines, link = self.context.service(CurrentSession), self._link
        if machines is None or machines.session is None:
            raise LinkError("homebot has no link to other machines now: see listen and connect of [ros]")
        if link is not None and link.session is machines.session:
            return link
        secret = read_password(self._settings.token_file, None, "token") or SecretStr("")
        wire = MachineWire(self.node, machines.session, secret)
        return MachineLink(wire, self.node.graph.clock, self.context.home, self._machine, self._settings.gateway)

    async def _call(
        self, service: str, request: Message, within: float = _ANSWERS_WITHIN, longest: float = _ANSWERS_WITHIN
    ) -> bytes:
        """Return the response of the other gateway, which does not begin after *within* seconds; see `MachineLink`."""
        if self._link is None or self._problem:
            raise LinkError(self._problem)
        return await self._link.call(service, request, within, longest)

    async def _send(self, command: Command) -> SendCommandResponse:
        if not self._may_act:
            why = self.observes_because
            return SendCommandResponse(success=False, message=why, problem="refused", unable=why == ONLY_OBSERVES)
        within = command.expires_after or _ANSWERS_WITHIN
        try:
            answer = await self._call("send_command", command, within, within + _ANSWERS_WITHIN)
            return message_from_cdr(SendCommandResponse, answer)
        except UnansweredError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="unanswered")
        except HomebotError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="unreachable")

    async def _send_raw(self, command: RawCommand) -> None:
        try:
            if not self._may_act:
                raise RefusedError("the command", self.observes_because)
            await self._call("out", command)
        except HomebotError as exc:
            if self._limit.allows(NOT_SENT) is not None:
                self.node.log.warning(NOT_SENT, message=f"not sent to {command.address[:100]}: {exc}")

    async def _describe(self, request: DescribeCommandsRequest) -> DescribeCommandsResponse:
        return message_from_cdr(DescribeCommandsResponse, await self._call("describe_commands", request))

    async def _pair(self, service: str, request: Message) -> PairResponse:
        try:
            if not self._may_act:
                raise RefusedError("pairing", self.observes_because)
            return message_from_cdr(PairResponse, await self._call(service, request, longest=_PAIRS_WITHIN))
        except LinkError as exc:
            return PairResponse(success=False, message=str(exc), problem="unreachable")
        except PeerError as exc:
            return PairResponse(success=False, message=str(exc), problem="refused")

    async def _health(self, request: HealthRequest) -> HealthResponse:
        gaps = self._link.gaps if self._link is not None else 0
        own = Count.each({"news_missed": gaps}, Severity.LOSS)
        own += Count.each({"announcements_refused": self._mirror.refused}, Severity.FAULT)
        try:
            health = message_from_cdr(HealthResponse, await self._call("health", request))
        except HomebotError as exc:
            return HealthResponse(counts=own, troubles=() if self._problem else (str(exc),))
        quarantined = tuple(device.model_copy(update={"gateway": self.node.name}) for device in health.quarantined)
        return health.model_copy(update={"counts": (*health.counts, *own), "quarantined": quarantined})

    async def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        """Deliver the raw messages of an address, which the machine mirrors on a topic of the device."""
        try:
            asked = request.model_copy(update={"listener": ""})
            there = message_from_cdr(SubscribeToTopicResponse, await self._call("subscribe_to_topic", asked))
            if not there.success:
                return there
            device = there.data_topic.partition("/received_data/")[2]
            publisher = self._listeners.add(request.topic, device, unescape_token(device), request.listener)
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        missed = tuple(topic.model_copy(update={"gateway": self.node.name}) for topic in there.missed)
        return there.model_copy(update={"data_topic": publisher.topic_name, "missed": missed})

    async def _listen_again(self, address: str) -> None:
        with suppress(HomebotError):  # the link is lost again, and this is done with the next one
            await self._call("subscribe_to_topic", SubscribeToTopicRequest(topic=address))
