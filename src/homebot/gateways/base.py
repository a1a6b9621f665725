"""What every gateway is: a node that speaks one protocol and brings its devices onto the graph."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.devices import GatewayNames, GatewayState, Sighting
from homebot.devices.gateway_state import ONLY_OBSERVES
from homebot.graph import DurabilityPolicy, Node, QoSProfile, qos_profile_latched

__all__ = ["Gateway"]

_SIGHTINGS_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Gateway(ABC):
    """The base of gateways; the plug-in group is ``homebot.gateways``.

    It publishes the sightings of its devices on ``/gateway/<name>/received_topics`` (kept for late joiners, newest per
    device) and its own state on ``/gateway/<name>/state``.

    Args:
        node: The node it is: ``/gateway/<name>``.
        settings: Its table of the configuration, checked; an instance of :attr:`Settings`.

    Attributes:
        Settings: The model of its table.
        node: That node.
        names: Its names on the graph.
        acts: Whether it sends commands to devices; a gateway that only observes says no to all of them.
        observes_because: Why it only observes, where it does, in words.
    """

    Settings: ClassVar[type[BaseModel]]
    acts: bool = True
    observes_because: str = ONLY_OBSERVES

    def __init__(self, node: Node, settings: BaseModel) -> None:  # noqa: ARG002  # what every gateway is given
        self.node = node
        self.names = GatewayNames(node.name)
        self._sightings = node.create_publisher(Sighting, self.names.received_topics, _SIGHTINGS_QOS)
        self._states = node.create_publisher(GatewayState, self.names.state, qos_profile_latched)

    @classmethod  # noqa: B027  # no duty: most gateways have nothing to look for
    def check(cls, settings: BaseModel) -> None:
        """Look for what *settings* name, such as files, before anything is started; nothing is connected.

        Args:
            settings: An instance of :attr:`Settings`.

        Raises:
            UsageError: The gateway could not work with them; names the key where there is one.
        """

    @abstractmethod
    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work until cancelled; say that you are ready with ``task_status.started()``."""

    def sight(self, sighting: Sighting) -> None:
        """Tell the graph of a device; one that is removed is not kept for late joiners."""
        self._sightings.publish(sighting)
        if sighting.kind == "removed":
            self._sightings.dispose(sighting.key)

    def report(self, state: Literal["active", "unavailable"], reason: str = "") -> None:
        """Tell the graph how the gateway is."""
        if not reason and not self.acts and self.observes_because != ONLY_OBSERVES:
            reason = self.observes_because
        self._states.publish(GatewayState(state=state, reason=reason, acts=self.acts))
