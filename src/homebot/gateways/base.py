"""The contract of gateways: nodes that bring the devices of one protocol onto the graph and command them.

A gateway is the node ``/gateway/<name>``. Its interface are these names below that node, see
:class:`homebot.devices.names.GatewayNames`. Every gateway must serve the first five; the others depend on its protocol.

=====================  ==========================================================================================
``received_topics``    topic: :class:`Sighting`; late joiners get the newest of each device
``readings``           topic: :class:`Report`; late joiners get the newest of each stream, but no events
``state``              topic: :class:`GatewayState`, latched
``send_command``       service: sends a :class:`Command` to a part, in values of the vocabulary
``health``             service: returns counters and problems
``describe_commands``  service: returns the messages that commands to a device would send, for approval
``out``                subscribed topic: :class:`RawCommand`, text to a text address or raw bytes to an address
``subscribe_to_topic`` service: requests the raw messages of an address, or the states of a part as text
``quarantine``         topic: :class:`Quarantine`, peers that broke the rules and are read slowly
``refresh``            service: asks a part for its values, and a group for those of its members
``offers``             subscribed topic: :class:`ExposedDevice`, a device of homebot for other systems
``offer_reports``      subscribed topic: :class:`ExposedState`, the states of those devices
``offer_commands``     topic: :class:`Command`, commands of those systems
=====================  ==========================================================================================

Apps that work with texts, such as the light service, need ``out`` and ``subscribe_to_topic``; typed handles do not.
:class:`homebot.gateways.announced.published_devices.PublishedDevices` implements the first nine except ``state``, for
gateways that know the parts of their devices; :mod:`homebot.gateways.memory` is the reference implementation, and
:mod:`homebot.testing.gateway_contract` the test suite.

A light that is set to a level above 0, a colour, a colour temperature or an effect must then be on, and at level 0 off.
If the protocol does not ensure that, the gateway must; :func:`homebot.devices.capabilities.implied_settings` returns
the settings to send.

*Key* is the gateway's name for a device, or for one announcement of it: unique in the gateway, and stable across
restarts. *Address* is a place in the protocol where the device reports or accepts commands (MQTT: a topic). In a
protocol without addresses the engine gives each part a text address (:func:`homebot.devices.names.text_address`).
*expires_at* is the time after which a silent device counts as stale: only the gateway knows how often its devices
report, and it publishes a new sighting whenever one does.

*Known* and *reachable* are different facts. A sighting means that a device is known; ``confirmed`` means that it was
itself heard, rather than read from a cache or list. If the protocol reports whether the device can be reached now,
the gateway publishes that as the capability ``reachable``; an unreachable device is still listed. ``removed`` means
that the device has left the house, never that it is silent.

While a crashed gateway waits for its restart, a node of its name publishes nothing but its ``state``, ``unavailable``.
After a restart the topics of a gateway are empty. The gateway finds its devices again, by asking or by waiting for
their announcements, and publishes a sighting of each; the directory keeps them meanwhile. After a restart of the
directory, the sightings and reports for late joiners restore everything, and the gateway need not do anything.

``unavailable`` with a reason is a normal state: the broker is away, the radio is unplugged. The gateway then keeps its
devices, keeps trying, answers commands with ``unreachable``, and never ends because of it. The directory lists its
devices as unreachable, except those that the gateway still reports as reachable over links of their own. A gateway is
ready (``task_status.started()``) after its first attempt to connect, successful or not.

*Unreachable* means that nothing was sent. A command that was sent but not acknowledged by the network is
``unanswered``: it may still take effect. A gateway sends no waiting command after its ``expires_after``.
"""

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from random import Random
from typing import ClassVar, Final, Generic, Literal, Self, TypeAlias, TypeVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.clock import Clock
from homebot.devices import GatewayNames, GatewayState, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.names import ONLY_OBSERVES, SENDS_NOTHING
from homebot.errors import HomebotError
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile, qos_profile_latched
from homebot.log import LogLimit
from homebot.units import Seconds

ServiceT = TypeVar("ServiceT")
ServiceT_co = TypeVar("ServiceT_co", covariant=True)

UNAVAILABLE: Final = "gateway.unavailable"
AVAILABLE: Final = "gateway.available"

Delivery: TypeAlias = Literal["inbox", "mirror"]
"""The way in which raw messages and texts are delivered; see :class:`GatewaySettings`."""

_NEWEST_OF_EACH = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass(frozen=True, slots=True)
class HostService(Generic[ServiceT_co]):
    """A service that gateways share in this process, such as the embedded broker.

    Attributes:
        kind: The class of the running service, its key in a :class:`GatewayContext`.
        start: Runs it; the context is entered when it is ready, and stops it when left. Gateways that share the
            service have the same.
        name: Its name for people; empty for one that several gateways may use.
    """

    kind: type[ServiceT_co]
    start: Callable[[Graph, Clock], AbstractAsyncContextManager[ServiceT_co]]
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class GatewayContext:
    """The surroundings of a gateway beside its node and settings; its clock is that of the node's graph.

    Attributes:
        random: The source of random numbers, seeded for reproducible runs; None for the gateway's own.
        services: The running host services by their class.
        is_dry_run: Whether nothing may be sent; gateways then accept commands without sending them.
        gateways: The plug-ins of all configured gateways; None if they are unknown.
        home: The name of the home; empty if it is unknown.
    """

    random: Random | None = None
    services: Mapping[type[object], object] = field(default_factory=dict)
    is_dry_run: bool = False
    gateways: frozenset[str] | None = None
    home: str = ""

    @classmethod
    def of(cls, *services: object, random: Random | None = None, is_dry_run: bool = False, home: str = "") -> Self:
        """Return a context with these running *services*."""
        return cls(random, {type(service): service for service in services}, is_dry_run, home=home)

    def service(self, kind: type[ServiceT]) -> ServiceT | None:
        """Return the running host service of the class *kind*, or None."""
        service = self.services.get(kind)
        return service if isinstance(service, kind) else None


class GatewaySettings(BaseModel):
    """The keys that the tables of all gateways share; the model of a gateway derives from it.

    Attributes:
        gone: The keys that a table had once, and what became of them, in words.
        act: Whether commands are sent; if false, the gateway only observes.
        delivery: ``inbox`` puts raw messages and texts into the one inbox of each node that asked for them; ``mirror``
            gives each device a topic ``/gateway/NAME/received_data/<device>``.
        stale_after: Seconds of silence after which a device counts as stale, unless it sets another limit.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    gone: ClassVar[Mapping[str, str]] = {}

    act: bool = True
    delivery: Delivery = "inbox"
    stale_after: Seconds = 3600.0


class Gateway(ABC):
    """The base of gateways; the plug-in group is ``homebot.gateways``. The module states the contract.

    Args:
        node: Its node, ``/gateway/<name>``.
        settings: Its validated table of the configuration; an instance of :attr:`Settings`.
        context: Services of its host; by default none.

    Attributes:
        Settings: The model of its table.
        names: Its names on the graph.
        reports: The publisher of its devices' reports.
        random: The source of random numbers for pauses.
        acts: Whether it sends commands to devices; if False, it refuses them all.
        observes_because: Why it only observes, in words.
        knows_people: Whether it may know persons, which are people of the house without a table.
    """

    Settings: ClassVar[type[BaseModel]]
    knows_people: ClassVar[bool] = False
    acts: bool = True
    observes_because: str = ONLY_OBSERVES

    def __init__(
        self,
        node: Node,
        settings: BaseModel,
        context: GatewayContext | None = None,
    ) -> None:
        self.node = node
        if isinstance(settings, GatewaySettings):
            self.acts = settings.act
        self.context = context or GatewayContext()
        if self.context.is_dry_run:
            self.acts, self.observes_because = False, SENDS_NOTHING
        self.names = GatewayNames(node.name)
        self._sightings = node.create_publisher(Sighting, self.names.received_topics, _NEWEST_OF_EACH)
        self.reports = node.create_publisher(Report, self.names.readings, _NEWEST_OF_EACH)
        self.random = self.context.random or Random()  # noqa: S311 - spreads attempts, protects nothing
        self._state: GatewayState | None = None
        self._states = node.create_publisher(GatewayState, self.names.state, qos_profile_latched)
        self._state_lines = LogLimit(node.graph.clock, burst=5)
        self._is_ready = False

    def offer_pictures(self, read: Callable[[str, str], Awaitable[bytes]]) -> None:
        """Offer the pictures of its devices; *read* is called with the key of a device and the id of a part."""

        def start() -> None:
            from homebot.devices.picture_messages import (  # noqa: PLC0415 - with the first look
                GetPicture,
                PictureRequest,
                PictureResponse,
                picture_of,
            )

            async def answer(request: PictureRequest) -> PictureResponse:
                try:
                    return picture_of(request.device[:100], await read(request.device, request.part))
                except HomebotError as exc:
                    return PictureResponse(success=False, message=str(exc))

            self.node.create_service(GetPicture, self.names.picture, answer, concurrent=True)

        load = partial(import_module, "homebot.devices.picture_messages")
        self.node.offer_service("homebot/srv/GetPicture", self.names.picture, start, load)

    @classmethod  # noqa: B027 - no duty: most gateways have nothing to look for
    def check(cls, settings: BaseModel) -> None:
        """Check the resources that *settings* name, such as files, before anything starts; does not connect.

        Raises:
            UsageError: One is unusable; the message names the key.
        """

    @classmethod  # noqa: B027 - no duty: most gateways have no server
    async def reach(cls, settings: BaseModel) -> None:
        """Log in to its server once, and disconnect.

        Raises:
            HomebotError: The server does not answer, or refuses.
        """

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:  # noqa: ARG003 - most need none
        """Return the services that it needs in this process; they outlive the gateway."""
        return ()

    @classmethod
    def other_machine(cls, name: str, settings: BaseModel) -> tuple[str, Path] | None:  # noqa: ARG003 - most are here
        """Return the machine that gateway *name* connects, and its secret's file; None if its devices are of this one.

        Devices of another machine get to no third one by this one.
        """
        return None

    @classmethod
    def resolve(cls, settings: BaseModel, context: GatewayContext) -> BaseModel:  # noqa: ARG003 - most change nothing
        """Return *settings* completed from the *context*; called once, not at each restart."""
        return settings

    @classmethod
    def observes(cls, settings: BaseModel) -> bool:
        """Return whether a gateway with *settings* sends no commands."""
        return isinstance(settings, GatewaySettings) and not settings.act

    @classmethod
    def home(cls, settings: BaseModel) -> str:  # noqa: ARG003 - most protocols carry one home
        """Return the name of the home in a protocol that carries several; empty for all of them."""
        return ""

    @classmethod
    def network(cls, settings: BaseModel) -> str:  # noqa: ARG003 - most have one network
        """Return the identity of its network, to remember devices by network; empty for the gateway's name."""
        return ""

    @abstractmethod
    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work until cancelled; call ``task_status.started()`` when ready."""

    def mark_ready(self, task_status: TaskStatus[None]) -> None:
        """Record the end of an attempt, successful or not; after the first one the gateway is ready."""
        if not self._is_ready:
            self._is_ready = True
            task_status.started()

    def publish_sighting(self, sighting: Sighting) -> None:
        """Publish a sighting; that of a removed device is not kept for late joiners."""
        self._sightings.publish(sighting)
        if sighting.kind == "removed":
            self._sightings.dispose(sighting.key)

    def publish_state(self, state: Literal["active", "unavailable"], reason: str = "") -> None:
        """Publish whether the gateway reaches the network of its devices, if that or the reason has changed.

        Args:
            state: ``unavailable`` if it does not; its devices stay.
            reason: The reason in words; empty if all is well.
        """
        if not reason and not self.acts and self.observes_because != ONLY_OBSERVES:
            reason = self.observes_because
        # Apps may check this state before they send a raw text, yet the journal should record the text.
        news = GatewayState(state=state, reason=reason, acts=self.acts or self.context.is_dry_run)
        if news != self._state:
            before, self._state = self._state, news
            self._states.publish(news)
            self.log_state(news, before)

    def log_state(self, state: GatewayState, before: GatewayState | None) -> None:
        """Log that the gateway became unavailable or works again; at most five lines in 10 s."""
        is_down, was_down = state.state == "unavailable", before is not None and before.state == "unavailable"
        if (is_down or was_down) and self._state_lines.allows("state") is not None:
            if is_down:
                self.node.log.warning(UNAVAILABLE, message=f"unavailable: {state.reason}", reason=state.reason)
            else:
                self.node.log.info(AVAILABLE, message="available again")
