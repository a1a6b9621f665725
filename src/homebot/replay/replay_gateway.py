"""The muted gateways of a replay, which send nothing, and the feed of recorded messages that they publish.

They fulfil the contract of :mod:`homebot.gateways.base`. Commands are answered like the recorded gateway did: as
unreachable while it was away, and as refused if it only observed. The device's answer is in the recording.
"""

import math
from bisect import bisect
from collections.abc import Awaitable, Callable
from typing import ClassVar, Final, TypeAlias, final

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.clock import Clock
from homebot.devices import GatewayState, RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.places_messages import OwnerRequest
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import HomebotError
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.base import GatewaySettings
from homebot.gateways.raw_delivery import PartTexts, RawDelivery, begin_of, missed
from homebot.graph import Node
from homebot.messages.message import Message
from homebot.recording.lines import GatewayNews
from homebot.recording.recording import Recording

_ACTIVE = GatewayState(state="active", reason="", acts=True)

_MOMENT: Final = 1e-6
"""Seconds within which messages belong to one moment; the resolution of the time of a line."""

Tell: TypeAlias = Callable[[Message], Awaitable[None]]
"""Publishes a message as its gateway."""


@final
class ReplayGateway(Gateway):
    """A gateway of a recording."""

    Settings: ClassVar[type[BaseModel]] = GatewaySettings

    def __init__(self, node: Node, settings: BaseModel, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._clock = node.graph.clock
        self._texts: dict[str, PartTexts] = {}
        self._told_state = _ACTIVE
        self._commands = 0
        self._listeners = RawDelivery(node, self.names, inboxes=True)
        node.create_subscription(RawCommand, self.names.out, self._on_raw, 1000)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe)
        node.create_service(SendCommand, self.names.send_command, self._accept)
        node.create_service(GetHealth, self.names.health, self._health)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Publish the messages before the recording, and then those of the feed, until cancelled."""
        feed = self.context.service(ReplayFeed)
        self._publish_told_state(_ACTIVE)
        if feed is not None:
            await feed.open(self.node.name, self.publish)
        task_status.started()
        await self._listeners.watch_nodes()

    async def publish(self, message: Message) -> None:
        """Publish a message of the recording like the gateway did."""
        match message:
            case GatewayNews(state=state):
                self._publish_told_state(state)
            case Sighting():
                heard_at = self._heard_at(message.seen_at.to_seconds())
                self.publish_sighting(message.model_copy(update={"heard_at": heard_at}))
            case Report():
                heard_at = self._heard_at(message.received_at.to_seconds())
                self.reports.publish(message.model_copy(update={"heard_at": heard_at}))
                if any(reading.capability in EVENTS for reading in message.readings):
                    self.reports.dispose(message.stream)  # events happen once
            case RawMessage():
                texts = self._texts.setdefault(message.address, PartTexts())
                texts.record(message, self._heard_at(message.received_at.to_seconds()), is_event=False)
                await self._listeners.deliver(message, wait_if_full=True)

    def _heard_at(self, stamp: float) -> float:
        return self._clock.monotonic() - (self._clock.now() - stamp)

    def _publish_told_state(self, state: GatewayState) -> None:
        self._told_state = state
        self.acts = state.acts
        self.publish_state(state.state, state.reason)

    def _accept(self, _: Command) -> SendCommandResponse:
        state = self._told_state
        if not state.acts:
            return SendCommandResponse(success=False, message=state.reason, problem="refused")
        if state.state == "unavailable":
            return SendCommandResponse(success=False, message=state.reason, problem="unreachable")
        self._commands += 1
        return SendCommandResponse(success=True)

    def _on_raw(self, _: RawCommand) -> None:
        self._commands += 1

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        address, is_new = request.topic, not self._listeners.has(request.topic, request.listener)
        try:
            publisher = self._listeners.add(address, address, address, request.listener)
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        since, kept = begin_of(request.since, self._clock), self._texts.get(address, PartTexts()).kept
        late = missed(kept, since) if is_new else ()
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=late)

    def _health(self, _: HealthRequest) -> HealthResponse:
        return HealthResponse(counts=(Count(name="commands_muted", count=self._commands),))


@final
class ReplayFeed:
    """The messages of gateways in a recording, each at its time.

    Messages of one moment are published together, like a burst from the network, unless there was a command or a
    statement of the owner in between, which later messages may be effects of. Messages at the time of a timer come
    after the timer, for which they wait a microsecond, as the times of lines are rounded.

    Args:
        settle: Returns when everything has happened that is due now.
    """

    def __init__(self, recording: Recording, clock: Clock, settle: Callable[[], Awaitable[None]]) -> None:
        self._recording = recording
        self._clock = clock
        self._settle = settle
        self._began = clock.monotonic()
        self._gateways: dict[str, Tell] = {}

    @property
    def now(self) -> float:
        """Seconds since the start of the recording."""
        return self._clock.monotonic() - self._began

    async def open(self, gateway: str, tell: Tell) -> None:
        """Publish the messages of *gateway* before the recording, and from now on the recorded ones."""
        for message in self._recording.before:
            if _gateway(message) == gateway:
                await tell(message)
        self._gateways[gateway] = tell

    async def play(self, ask_directory: Callable[[OwnerRequest], Awaitable[None]]) -> None:
        """Publish all events, and call *ask_directory* with the owner's requests; return at the end."""
        given = sorted(command.line for command in self._recording.commands)
        before, moment = 0, -math.inf
        for event in self._recording.events:
            is_effect = bisect(given, before) != bisect(given, event.line)
            is_asked = isinstance(event.message, OwnerRequest)
            if is_effect or is_asked or event.at - moment > _MOMENT:
                await self._wait_until(event.at)
                moment = event.at
            if isinstance(event.message, OwnerRequest):
                await ask_directory(event.message)
                moment = -math.inf
            else:
                if (tell := self._gateways.get(_gateway(event.message))) is not None:
                    await tell(event.message)
            before = event.line
        await self._wait_until(self._recording.ends_at)

    async def _wait_until(self, at: float) -> None:
        await anyio.sleep(max(0.0, at + _MOMENT - self.now))
        await self._settle()


def _gateway(message: Message) -> str:
    return str(getattr(message, "gateway", ""))
