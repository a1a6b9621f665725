"""The MQTT gateway: reads what devices publish on a broker, and sends them the commands of the graph.

Messages are handled in the broker's order, in batches. One of QoS 1 or 2 is acknowledged only after every listener
has it in its queue; should this process die before that, the broker sends it again.
"""

import platform
import re
import secrets
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.clock import TimeSlice
from homebot.conventions.installed_conventions import find_conventions
from homebot.conventions.payload import MAX_LONG_STATE_BYTES
from homebot.devices import GatewayState, SubscribeToTopic
from homebot.devices.gateway_messages import CommandAnswer
from homebot.errors import ClosedError, RefusedError
from homebot.gateways.base import UNAVAILABLE, Gateway, GatewayContext, HostService
from homebot.gateways.mqtt.acting_lease import ActingLease
from homebot.gateways.mqtt.command_publisher import Responses
from homebot.gateways.mqtt.embedded_broker import hosted_broker
from homebot.gateways.mqtt.engine import AnnouncedDevices
from homebot.gateways.mqtt.registry import TopicReaders
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.graph import Node, QoSProfile
from homebot.log import LogLimit
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.clients import HostedBroker, client_maker
from homebot.mqtt.connection import ConnectionState, LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.support.isolation import isolated, run_as

OVERSIZE = "gateway.oversize"

_TURN = 200
"""Messages delivered before their readers get a turn: fewer than the 256 that a reader takes at once, so that a burst
of QoS 0 does not overrun the inbox of a reader that keeps up."""

_ANNOUNCED = 7
"""How many messages an announcement counts for, and again for each kB. A whole house is announced at once: about 25
announcements, 4 ms of work, share one turn, one subscription and one check."""

_ANSWERS = QoSProfile(depth=1000)
"""Room for the answers to commands to a whole house; the oldest is lost first, and its command has no answer."""


CONNECTED = "gateway.connected"
LOST = "gateway.link_lost"
NOT_HEARD = "gateway.subscription_refused"
NO_ANSWER = "gateway.no_answer"

ANSWER_WAIT = 2.0
"""Seconds for which startup waits for the broker's answer; the gateway keeps trying after that."""

_MAX_NAMES = 10
_DOWN = frozenset({LinkPhase.WAITING, LinkPhase.REFUSED})
_TRYING = frozenset({LinkPhase.CONNECTING, LinkPhase.SUBSCRIBING})

TRIES_EVERY = 600.0
"""Seconds between two log lines about failed attempts with one reason: a broker may be away for days."""

MAX_LOSSES = 5
"""Most log lines about a lost link in ten seconds."""


class LinkReport:
    """Logs and publishes the states of a connection.

    Args:
        listening_to: The subject of the subscriptions, for the log.
        filters: Subscriptions of which at least one must be granted for the gateway to receive anything.
    """

    def __init__(self, gateway: Gateway, connection: MqttConnection, listening_to: str, filters: Sequence[str]) -> None:
        self._gateway = gateway
        self._connection = connection
        self._listening_to = listening_to
        self._filters = filters
        self._tried = anyio.Event()
        self._was_up = False
        clock = gateway.node.graph.clock
        self._tries = LogLimit(clock, TRIES_EVERY)
        self._losses = LogLimit(clock, burst=MAX_LOSSES)

    async def wait_for_first_try(self) -> None:
        """Wait for the end of the first attempt to connect, for at most 2 s."""
        with anyio.move_on_after(ANSWER_WAIT):
            await self._tried.wait()
            return
        self._gateway.node.log.warning(
            NO_ANSWER,
            message=f"{self._connection.url} has not answered yet; still trying",
            broker=self._connection.url,
        )

    async def watch(self) -> None:
        """Report each state until the connection is closed."""
        async for state in self._connection.states():
            if state.phase is LinkPhase.CONNECTED:
                self._on_connected()
            elif state.phase in _DOWN or (self._was_up and state.phase is not LinkPhase.CLOSED):
                self._down(state)  # after a loss the next attempt starts at once, and may take ten seconds
            self._was_up = state.phase is LinkPhase.CONNECTED
            if state.phase not in _TRYING:
                self._tried.set()

    def _on_connected(self) -> None:
        if self._was_up:
            self._gateway.publish_state("unavailable", "the connection was lost")  # and restored at once
        url, refused = self._connection.url, self._connection.refused
        observing = "" if self._gateway.acts else " (observing only)"
        hears = f"listening to {self._listening_to}{observing}"
        if not refused:
            self._gateway.publish_state("active")
            self._gateway.node.log.info(CONNECTED, message=f"connected to {url}, {hears}", broker=url)
            return
        names = ", ".join(list(refused)[:_MAX_NAMES]) + (", …" if len(refused) > _MAX_NAMES else "")
        reason = f"the broker refused the subscription to {names}: {next(iter(refused.values()))}"
        is_deaf = all(topic_filter in refused for topic_filter in self._filters)
        self._gateway.publish_state("unavailable" if is_deaf else "active", reason)
        outcome = "it receives nothing" if is_deaf else hears
        self._gateway.node.log.warning(NOT_HEARD, message=f"connected to {url}, but {reason}; {outcome}", broker=url)

    def _down(self, state: ConnectionState) -> None:
        url = self._connection.url
        reason = state.reason.removeprefix(f"{url}: ")
        self._gateway.publish_state("unavailable", f"{url}: {reason}")
        event, limit = (LOST, self._losses) if self._was_up else (UNAVAILABLE, self._tries)
        if limit.allows(event if self._was_up else reason) is None:
            return
        what = f"lost the connection to {url}" if self._was_up else f"cannot connect to {url}"
        soon = "trying again" if not state.retry_in or state.retry_in < 2 else f"trying again in {state.retry_in:.0f} s"
        self._gateway.node.log.warning(event, message=f"{what}: {reason}; {soon}", broker=url, reason=reason)


class MqttGateway(Gateway):
    """Brings the devices on one MQTT broker onto the graph.

    Args:
        context: Services of its host; a :class:`homebot.mqtt.clients.HostedBroker` makes the client.
    """

    Settings: ClassVar[type[BaseModel]] = MqttGatewaySettings

    def __init__(self, node: Node, settings: MqttGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        random, hosted = self.context.random, self.context.service(HostedBroker)
        make_client = (hosted and hosted.make_client) or client_maker(settings.client or "aiomqtt")
        computer = (hosted and hosted.computer) or platform.node()
        self.acts = bool(settings.act)
        if settings.share:
            self.observes_because = f"it shares the group {settings.share}; a homebot without share sends commands"
        self._settings = settings
        # Unlike the client id this name is stable, or each run would leave one more retained topic on the broker.
        status_topic = f"homebot/{_topic_level(computer)}/{node.name}/status"
        self._connection = MqttConnection(
            settings.options(),
            make_client,
            status_topic=status_topic,
            clock=node.graph.clock,
            random=random,
            is_paced=hosted is None or settings.url != hosted.url,
        )
        self._lease = ActingLease(self, self._connection, settings.root, f"{node.name} on {computer}", random)
        self._responses = self._asked_responses() if settings.responses else None
        self._described = AnnouncedDevices(
            self,
            find_conventions(settings.conventions, settings.tables, settings.root, self.context.home),
            self._connection,
            self._lease,
            settings,
            make_client,
            self._responses,
        )
        self.counters = self._described.counters
        if node.name == "mqtt":
            node.create_service(SubscribeToTopic, "/subscribe_to_mqtt_topic", self._described.texts.subscribe)
        self.offer_pictures(partial(self._read_picture, make_client))

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Load the conventions and the client's libraries, and read the credentials.

        Raises:
            UsageError: A convention cannot be loaded, a file cannot be read, or settings contradict each other.
        """
        if isinstance(settings, MqttGatewaySettings):
            find_conventions(settings.conventions, settings.tables, settings.root)
            settings.check_files()
            if settings.embedded is None:
                settings.options()
                client_maker(settings.client or "aiomqtt")  # loaded now, while nothing waits for it

    @classmethod
    async def reach(cls, settings: BaseModel) -> None:
        """Log in to the configured broker, with a client id other than that of the gateway, which may be running."""
        if isinstance(settings, MqttGatewaySettings) and settings.embedded is None:
            options = replace(settings.options(), client_id=f"homebot-{secrets.token_hex(4)}", session_expiry=0)
            async with client_maker(settings.client or "aiomqtt")(options).connected():
                pass

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:
        """Return the embedded broker if no address is given."""
        ports = settings.embedded if isinstance(settings, MqttGatewaySettings) else None
        return () if ports is None else (hosted_broker(ports),)

    @classmethod
    def resolve(cls, settings: BaseModel, context: GatewayContext) -> BaseModel:
        """Fill in the address of the embedded broker, and a client id from the given random numbers.

        Only simulated devices and homebot itself use the embedded broker, so there the gateway acts by default.
        """
        if not isinstance(settings, MqttGatewaySettings):
            return settings
        if context.random is not None:
            settings = settings.with_client_id(f"homebot-{context.random.getrandbits(32):08x}")
        hosted = context.service(HostedBroker)
        if hosted is None or settings.embedded is None:
            return settings
        act = not settings.share if settings.act is None else settings.act
        return settings.model_copy(update={"url": hosted.url, "act": act, "client": settings.client or "native"})

    @classmethod
    def observes(cls, settings: BaseModel) -> bool:
        """Return whether a gateway with *settings* sends no commands: the default for all but the embedded broker."""
        if not isinstance(settings, MqttGatewaySettings):
            return False
        return settings.embedded is None or bool(settings.share) if settings.act is None else not settings.act

    @classmethod
    def home(cls, settings: BaseModel) -> str:
        """Return the first level of its topics; empty for every home on the broker."""
        return settings.root if isinstance(settings, MqttGatewaySettings) else ""

    @classmethod
    def network(cls, settings: BaseModel) -> str:
        """Return the broker's host and port, without credentials; ``embedded[:port]`` for the embedded broker."""
        if not isinstance(settings, MqttGatewaySettings):
            return ""
        if settings.embedded is not None:
            return settings.url
        options = MqttOptions.from_url(settings.url)
        return f"{options.host.lower()}:{options.port}"

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the link and handle messages until cancelled; ready after the first attempt to connect."""
        texts = self._settings.text_subscriptions(self._described.text_filters)
        announcements = self._described.filters
        async with self._connection as connection, anyio.create_task_group() as tasks:
            await connection.subscribe(*texts)
            await connection.subscribe(
                *(MqttSubscription(announcement, no_local=True) for announcement in announcements), every_link=True
            )
            if self._responses is not None:
                await connection.subscribe(MqttSubscription(self._responses.topic, qos=1, no_local=True))
            heard = (*(text.filter for text in texts), *announcements)
            report = LinkReport(self, connection, self._settings.root or "every home", heard)
            tasks.start_soon(self._receive, connection)
            looks = () if self.context.service(HostedBroker) else (self._described.census.serve,)
            for work in (report.watch, self._described.serve, self._lease.serve, *looks):
                tasks.start_soon(run_as, self.node.full_name, work)
            await report.wait_for_first_try()
            task_status.started()

    def log_state(self, state: GatewayState, before: GatewayState | None) -> None:
        """Log nothing: :class:`LinkReport` logs more, and earlier."""

    async def _receive(self, connection: MqttConnection) -> None:
        with isolated(self.node.full_name):
            while True:
                try:
                    batch = await connection.receive()
                except ClosedError:
                    return
                await self._handle(batch)
                connection.ack(batch)
                del batch  # not kept while waiting for the next one: all retained messages are tens of megabytes

    async def _read_picture(self, make_client: Callable[[MqttOptions], MqttClient], key: str, part: str) -> bytes:
        from homebot.mqtt.next_message import next_message  # noqa: PLC0415 - with the first look

        camera = self._described.find_part(key, part).described.part
        if camera.service_type != "camera" or not camera.reads:
            raise RefusedError(f"a picture of {key[:100]}", "it announced none")
        return await next_message(camera.reads[0], self._settings.options(), make_client)

    def _asked_responses(self) -> Responses:
        answers = self.node.create_publisher(CommandAnswer, self.names.answers, _ANSWERS)
        topic = f"homebot/responses/{_topic_level(self._settings.client_id)}"
        return Responses(self.node.name, topic, self.node.graph.clock, answers.publish)

    async def _handle(self, batch: Iterable[MqttMessage]) -> None:
        described, lease = self._described, self._lease
        responses, max_payload = self._responses, self._settings.max_payload
        described.tick()
        turn, work = TimeSlice(self.node.graph.clock), 0
        for message in batch:
            work += 1
            if work >= _TURN or (work > 1 and turn.is_over):
                work = 0
                await turn.pause()
            topic, payload, qos, retained, _, _ = message
            if topic in lease.topics:
                lease.on_message(message)
                continue
            if responses is not None and topic == responses.topic:
                responses.on_response(message)
                continue
            route = described.route(topic)
            if len(payload) > max_payload:
                work += await self._handle_long(message, route)
            elif route is None:
                described.offers.handle_command(message)
            elif route.only_text is not None and payload:
                await described.read_text(topic, payload, route.only_text, retained=retained, wait_if_full=qos > 0)
            elif route.only_states:
                work += len(route.announced_parts)
                if (left := described.read_states(message, route, turn)) is not None:
                    await left
            else:
                readers = len(route.conventions) + len(route.texts)
                work += _ANNOUNCED * (1 + len(payload) // 1024) * readers + len(route.announced_parts)
                await described.handle_message(message, route)

    async def _handle_long(self, message: MqttMessage, route: TopicReaders | None) -> int:
        """Handle a message over the usual limit, which must be an announcement; return its amount of work."""
        work = 0
        if route is not None and route.conventions:
            work = _ANNOUNCED * (1 + len(message.payload) // 1024) * len(route.conventions)
            if len(message.payload) <= MAX_LONG_STATE_BYTES:
                await self._described.handle_message(message, route, raw=False)
                return work + len(route.announced_parts)
            await self._described.handle_announcement(message, route)
            if not route.announced_parts and not route.availability_readers:
                return work
        self.counters.oversize += 1
        self._described.quarantine.log_limited(
            OVERSIZE, f"{len(message.payload)} bytes on {message.topic}", source=message.topic
        )
        return work


def _topic_level(text: str) -> str:
    return re.sub(r"[+#/\0]", "_", text) or "unknown"
