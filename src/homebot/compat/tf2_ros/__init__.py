"""The tf2_ros API on :class:`homebot.places.transforms.TransformBuffer`.

A listener runs on the graph's event loop, so that a lookup may wait for a transform in any callback.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from time import monotonic, sleep
from typing import Any, Final

from homebot.compat.clock import RclpyDuration
from homebot.compat.messages import program_type, to_graph, to_program
from homebot.compat.remote import CONTEXT, Remote
from homebot.graph import DurabilityPolicy, QoSProfile, qos_profile_latched
from homebot.messages.tf2_msgs import TFMessage
from homebot.places.transforms import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformBuffer,
    TransformException,
)

__all__ = [
    "Buffer",
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "StaticTransformBroadcaster",
    "TransformBroadcaster",
    "TransformException",
    "TransformListener",
]

_PAUSE: Final = 0.01
_LISTENING: Final = QoSProfile(depth=100)
_LISTENING_TO_STATIC: Final = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_AT_ONCE: Final = RclpyDuration()


class Buffer:
    """The transforms between frames; how long they are kept is homebot's choice."""

    def __init__(self, *_: object, **__: object) -> None:
        self._transforms = TransformBuffer()

    def listen(self, node: Remote) -> None:
        """Insert what comes on ``/tf`` and ``/tf_static``; invalid transforms are left out."""
        listen = partial(CONTEXT.call, node.graph_object.create_subscription, TFMessage)
        listen("/tf", partial(_insert, self._transforms.set_transform), _LISTENING)
        listen("/tf_static", partial(_insert, self._transforms.set_transform_static), _LISTENING_TO_STATIC)

    def set_transform(self, transform: Any, authority: str) -> None:
        """Insert a ``geometry_msgs/msg/TransformStamped`` of the sender *authority*."""
        CONTEXT.call(self._transforms.set_transform, to_graph(transform), authority)

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Insert a transform that holds at any time."""
        CONTEXT.call(self._transforms.set_transform_static, to_graph(transform), authority)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: RclpyDuration = _AT_ONCE
    ) -> Any:
        """Return the transform at *time*, at 0 the latest one; wait for it up to *timeout*."""
        at = to_graph(time.to_msg() if hasattr(time, "to_msg") else time)
        ends = monotonic() + timeout.nanoseconds / 10**9
        while True:
            try:
                return to_program(CONTEXT.call(self._transforms.lookup_transform, target_frame, source_frame, at))
            except TransformException:
                if monotonic() >= ends:
                    raise
                sleep(_PAUSE)

    def can_transform(self, target_frame: str, source_frame: str, time: Any, timeout: RclpyDuration = _AT_ONCE) -> bool:
        """Return whether :meth:`lookup_transform` finds a transform."""
        with suppress(TransformException):
            self.lookup_transform(target_frame, source_frame, time, timeout)
            return True
        return False


class TransformListener:
    """Fills *buffer* with the transforms that are published."""

    def __init__(self, buffer: Buffer, node: Remote, **_: object) -> None:
        buffer.listen(node)


class TransformBroadcaster:
    """Publishes transforms on ``/tf``."""

    def __init__(self, node: Any, qos: Any = 100) -> None:
        self._publisher = node.create_publisher(TFMessage, "/tf", qos)

    def sendTransform(self, transform: Any) -> None:  # noqa: N802 - tf2's name
        """Publish one or several transforms."""
        self._publisher.publish(program_type(TFMessage)(transforms=_several(transform)))


class StaticTransformBroadcaster(TransformBroadcaster):
    """Publishes transforms that hold at any time, each message with all of them, on ``/tf_static``."""

    def __init__(self, node: Any, qos: Any = qos_profile_latched) -> None:
        self._publisher = node.create_publisher(TFMessage, "/tf_static", qos)
        self._sent: dict[str, Any] = {}

    def sendTransform(self, transform: Any) -> None:  # noqa: N802 - tf2's name
        """Add one or several transforms, and publish all."""
        self._sent |= {single.child_frame_id: single for single in _several(transform)}
        super().sendTransform(list(self._sent.values()))


def _several(transform: Any) -> list[Any]:
    return list(transform) if isinstance(transform, list | tuple) else [transform]


def _insert(insert: Callable[..., object], message: TFMessage) -> None:
    for transform in message.transforms:
        with suppress(TransformException):
            insert(transform)
