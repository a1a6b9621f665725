"""The contract of gateways: nodes that bring the devices of one protocol onto the graph and command them.

A gateway is the node ``/gateway/<name>``. All that others know of it are these names below that node, which
:class:`homebot.devices.names.GatewayNames` spells. The first five are duties of every gateway; the others depend on
its protocol.

=====================  ==========================================================================================
``received_topics``    topic: :class:`Sighting`, the newest of each device kept for late joiners
``readings``           topic: :class:`Report`, the newest of each stream kept for late joiners; events are not kept
``state``              topic: :class:`GatewayState`, latched
``send_command``       service: a :class:`Command` to a part, in the values of the vocabulary
``health``             service: its counters and its problems
``describe_commands``  service: the messages that commands to a device would send, for its owner's approval
``out``                topic it reads: :class:`RawCommand`, a text to a text address, or raw bytes to an address
``subscribe_to_topic`` service: delivery of the raw messages of an address, or of a part's states as text
``quarantine``         topic: :class:`Quarantine`, the peers that it listens to no more often than it can afford
``offers``             topic it reads: :class:`ExposedDevice`, a device that homebot shows to other systems there
``offer_reports``      topic it reads: :class:`ExposedState`, the states of those devices
``offer_commands``     topic: :class:`Command`, the commands of those systems
=====================  ==========================================================================================

Apps that work with texts, such as the light service, need ``out`` and ``subscribe_to_topic``; typed handles do not.
:class:`homebot.gateways.announced.published_devices.PublishedDevices` has the first nine but ``state``, for gateways
that know their devices' parts; :mod:`homebot.gateways.memory` is the reference, and
:mod:`homebot.testing.gateway_contract` the test.

A light that is told a level above 0, a colour, a colour temperature or an effect is on afterwards, and off at level 0.
Where the protocol does not see to that, the gateway does;
:func:`homebot.devices.capabilities.implied_settings` has the settings to send.

*Key* is the gateway's name for a device, or one announcement of it: unique in the gateway, and the same after a
restart. *Address* is a place in the protocol where the device reports or takes commands (MQTT: a topic); a protocol
without any has the text addresses of its parts (:func:`homebot.devices.names.text_address`), which the
engine makes. *expires_at* is when silence begins to count: the gateway alone knows how often its devices report, and
sends a new sighting each time one does; the directory calls a device stale that was not sighted until then.

*Advertised* and *reachable* are two facts. A sighting says that a device is known; ``confirmed`` says that the device
itself was heard, rather than a note kept of it. Whether it can be reached now is a report of the capability
``reachable``, and only where the protocol says so; a device that cannot be reached is still there. ``removed`` means
taken out of the house, never "silent".

After a restart of the gateway its topics are empty. It is the gateway that finds its devices again, by asking or by
waiting for their announcements, and sights each anew; the directory keeps them meanwhile. After a restart of the
directory, the sightings and reports kept for late joiners tell it everything, and the gateway does nothing.

``unavailable`` with a reason is a normal state: the broker is away, the radio is unplugged. The gateway then keeps its
devices, goes on trying, answers commands with ``unreachable``, and never ends because of it; the directory has its
devices as unreachable, but for those that it still reports as reachable, by links of their own. It is ready
(``task_status.started()``) when its first try has ended, successful or not.

*Unreachable* says that nothing was sent. A command that was sent, and that the network did not acknowledge, is
``unanswered``: it may still have its effect. Nothing that waits in the gateway is sent after ``expires_after``.
"""

from abc import ABC, abstractmethod
from random import Random
from typing import ClassVar, Final, Literal, TypeAlias

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import GatewayNames, GatewayState, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.names import ONLY_OBSERVES, SENDS_NOTHING
from homebot.gateways.context import GatewayContext, HostService
from homebot.graph import DurabilityPolicy, Node, QoSProfile, qos_profile_latched
from homebot.log import LogLimit
from homebot.units import Seconds

__all__ = ["AVAILABLE", "UNAVAILABLE", "Delivery", "Gateway", "GatewaySettings"]

UNAVAILABLE: Final = "gateway.unavailable"
AVAILABLE: Final = "gateway.available"

Delivery: TypeAlias = Literal["inbox", "mirror"]
"""Where raw messages and texts are delivered; see :class:`GatewaySettings`."""

_NEWEST_OF_EACH = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class GatewaySettings(BaseModel):
    """The keys that the table of every gateway has; a gateway's own model derives from it and adds its own.

    Attributes:
        act: Whether commands are carried out; false observes only.
        delivery: ``inbox`` puts raw messages and texts into the one inbox of each node that asked for them; ``mirror``
            gives each device a topic ``/gateway/NAME/received_data/<device>``.
        stale_after: Seconds of silence after which a device counts as stale that says nothing else.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    act: bool = True
    delivery: Delivery = "inbox"
    stale_after: Seconds = 3600.0


class Gateway(ABC):
    """The base of gateways; the plug-in group is ``homebot.gateways``. The module states the contract.

    Args:
        node: The node it is: ``/gateway/<name>``.
        settings: Its table of the configuration, checked; an instance of :attr:`Settings`.
        context: Services of its host; by default none.

    Attributes:
        Settings: The model of its table.
        names: Its names on the graph.
        reports: The publisher of its devices' reports.
        random: The source of random numbers, for pauses.
        acts: Whether it sends commands to devices; a gateway that only observes refuses them all.
        observes_because: The reason why it only observes, as text.
    """

    Settings: ClassVar[type[BaseModel]]
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

    @classmethod  # noqa: B027 - no duty: most gateways have nothing to look for
    def check(cls, settings: BaseModel) -> None:
        """Look for the resources in *settings*, such as files, before anything is started; nothing is connected.

        Raises:
            UsageError: The gateway could not work with them; names the key if there is one.
        """

    @classmethod  # noqa: B027 - no duty: most gateways have no server
    async def reach(cls, settings: BaseModel) -> None:
        """Log in to its server once, and leave again.

        Raises:
            HomebotError: The server does not answer, or refuses.
        """

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:  # noqa: ARG003 - most need none
        """Return the services that it needs in this process; they run before it is made, and until it has stopped."""
        return ()

    @classmethod
    def resolve(cls, settings: BaseModel, context: GatewayContext) -> BaseModel:  # noqa: ARG003 - most change nothing
        """Return *settings* completed from the *context*; called once, also if the gateway is restarted."""
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
        """Return the identity of its network; the devices of each network are remembered apart. Empty for its name."""
        return ""

    @abstractmethod
    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work until cancelled; call ``task_status.started()`` when ready."""

    def mark_ready(self, task_status: TaskStatus[None]) -> None:
        """Record the end of a try, successful or not; after the first one the gateway is ready."""
        if not self._is_ready:
            self._is_ready = True
            task_status.started()

    def publish_sighting(self, sighting: Sighting) -> None:
        """Publish that a device is there, still there, or gone; one that is gone is not kept for late joiners."""
        self._sightings.publish(sighting)
        if sighting.kind == "removed":
            self._sightings.dispose(sighting.key)

    def publish_state(self, state: Literal["active", "unavailable"], reason: str = "") -> None:
        """Publish whether the gateway reaches its devices' network; a repeated state is not published.

        Args:
            state: ``unavailable`` where it does not; its devices stay.
            reason: The reason, as text for people; empty if all is well.
        """
        if not reason and not self.acts and self.observes_because != ONLY_OBSERVES:
            reason = self.observes_because
        # Apps send a raw text only where that says that commands are taken; the journal shall have it.
        news = GatewayState(state=state, reason=reason, acts=self.acts or self.context.is_dry_run)
        if news != self._state:
            before, self._state = self._state, news
            self._states.publish(news)
            self.log_state(news, before)

    def log_state(self, state: GatewayState, before: GatewayState | None) -> None:
        """Log that the gateway became unavailable, or works again; of more than five such lines in 10 s, five."""
        is_down, was_down = state.state == "unavailable", before is not None and before.state == "unavailable"
        if (is_down or was_down) and self._state_lines.allows("state") is not None:
            if is_down:
                self.node.log.warning(UNAVAILABLE, message=f"unavailable: {state.reason}", reason=state.reason)
            else:
                self.node.log.info(AVAILABLE, message="available again")
