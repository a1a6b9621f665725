"""rclpy's callbacks for events of quality of service, which run on the thread that spins their node."""

from collections.abc import Callable
from functools import partial
from typing import Any

from homebot.compat.remote import CONTEXT, Remote
from homebot.graph import qos_events

_Callback = Callable[[Any], object] | None


class PublisherEventCallbacks:
    """The callbacks of a publisher; that for incompatible qualities is not called: such ends are an error here."""

    deadline_status: type[qos_events.QosStatus] = qos_events.OfferedDeadlineMissedStatus
    liveliness_status: type[qos_events.QosStatus] = qos_events.LivelinessLostStatus

    def __init__(
        self, *, deadline: _Callback = None, liveliness: _Callback = None, matched: _Callback = None, **_: object
    ) -> None:
        self._callbacks = {
            self.deadline_status: deadline,
            self.liveliness_status: liveliness,
            qos_events.MatchedStatus: matched,
        }

    def watch(self, end: Remote) -> None:
        """Call the callbacks for the events of *end*."""
        for status, callback in self._callbacks.items():
            if callback is not None:
                CONTEXT.call(end.graph_object.on_event, status, partial(end.executor.submit, callback))


class SubscriptionEventCallbacks(PublisherEventCallbacks):
    """The callbacks of a subscription."""

    deadline_status = qos_events.RequestedDeadlineMissedStatus
    liveliness_status = qos_events.LivelinessChangedStatus
