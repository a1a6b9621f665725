"""``/rosout``: every log line as a message, fed by structlog."""

import asyncio
import threading
from contextlib import suppress

from structlog.typing import EventDict, WrappedLogger

from homebot.graph.node import Node
from homebot.graph.qos import qos_profile_rosout
from homebot.messages.builtin_interfaces import Time
from homebot.messages.rcl_interfaces import Log
from homebot.support.logger import sentence

_LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40, "critical": 50}


class RosoutFeed:
    """A structlog processor that publishes each line on ``/rosout`` and passes it on unchanged, from any thread.

    Args:
        node: The publishing node, created in the thread of its event loop. After its end, lines pass unpublished.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(Log, "/rosout", qos_profile_rosout)
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()

    def __call__(self, _logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
        """Publish *event* and return it."""
        line = Log(
            stamp=Time.from_seconds(self._node.graph.clock.now()),
            level=_LEVELS.get(str(event.get("level")), 20),
            name=_text(event.get("node", "homebot")).strip("/").replace("/", "."),
            msg=_text(sentence(event)),
            file="",
            function="",
            line=0,
        )
        if threading.get_ident() == self._thread:
            self._publish(line)
        else:
            with suppress(RuntimeError):  # the loop may be closed before the other thread ends
                self._loop.call_soon_threadsafe(self._publish, line)
        return event

    def _publish(self, line: Log) -> None:
        if not self._node.is_closed:
            self._publisher.publish(line)


def _text(value: object) -> str:
    """Return *value* as valid UTF-8 text; lone surrogates, such as from odd file names, become ``?``."""
    return str(value).encode(errors="replace").decode()
