"""``/rosout``: every log line as a message, fed by structlog."""

from __future__ import annotations

from structlog.typing import EventDict, WrappedLogger

from homebot.graph.node import Node
from homebot.graph.qos import qos_profile_rosout
from homebot.log import sentence
from homebot.messages.builtin_interfaces import Time
from homebot.messages.rcl_interfaces import Log

__all__ = ["RosoutFeed"]

_LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40, "critical": 50}


class RosoutFeed:
    """A structlog processor that publishes each line on ``/rosout`` and passes it on unchanged.

    Args:
        node: The node that publishes. Once it is closed, lines pass without being published.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(Log, "/rosout", qos_profile_rosout)

    def __call__(self, _logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
        """Publish *event* and return it."""
        if not self._node.is_closed:
            self._publisher.publish(
                Log(
                    stamp=Time.from_seconds(self._node.graph.clock.now()),
                    level=_LEVELS.get(str(event.get("level")), 20),
                    name=str(event.get("node", "homebot")).strip("/").replace("/", "."),
                    msg=sentence(event),
                    file="",
                    function="",
                    line=0,
                )
            )
        return event
