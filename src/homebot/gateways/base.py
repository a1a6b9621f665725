"""What every gateway is: a node that speaks one protocol and brings its devices onto the graph."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.devices import GatewayNames, Sighting
from homebot.graph import DurabilityPolicy, Node, QoSProfile, qos_profile_latched
from homebot.messages import Message

__all__ = ["Gateway", "GatewayState"]

_SIGHTINGS_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class GatewayState(Message):
    """Whether a gateway reaches its protocol's world.

    Attributes:
        state: ``active`` or ``unavailable``.
        reason: Why it is unavailable, in words.
    """

    state: Literal["active", "unavailable"]
    reason: str


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
    """

    Settings: ClassVar[type[BaseModel]]

    def __init__(self, node: Node, settings: BaseModel) -> None:  # noqa: ARG002  # what every gateway is given
        self.node = node
        self.names = GatewayNames(node.name)
        self._sightings = node.create_publisher(Sighting, self.names.received_topics, _SIGHTINGS_QOS)
        self._states = node.create_publisher(GatewayState, "~/state", qos_profile_latched)

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
        self._states.publish(GatewayState(state=state, reason=reason))
