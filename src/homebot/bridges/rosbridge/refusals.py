"""Refusals for want of a right: logged with a limit, and published on the graph."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from homebot.bridges.client_error_log import ClientErrorLog, short_text
from homebot.devices.access_messages import AccessRefused
from homebot.devices.names import ACCESS_REFUSALS
from homebot.graph import Node, Publisher, QoSProfile
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
    from homebot.bridges.rosbridge.protocol import Operation

__all__ = ["Refusals", "operation_text"]

_QOS: Final = QoSProfile(depth=100)
_LONGEST_NAME: Final = 247
_SHOWN: Final = 100
_DEEDS: Final = {
    "advertise": "advertising",
    "unadvertise": "unadvertising",
    "publish": "publishing on",
    "subscribe": "subscribing to",
    "unsubscribe": "unsubscribing from",
    "call_service": "calling",
    "service_response": "answering a call of",
    "advertise_service": "offering",
    "unadvertise_service": "withdrawing",
    "send_action_goal": "sending a goal to",
    "cancel_action_goal": "cancelling a goal of",
    "action_feedback": "giving feedback of",
    "action_result": "ending a goal of",
    "advertise_action": "offering",
    "unadvertise_action": "withdrawing",
}


@final
class Refusals:
    """Record of each refusal for want of a right. Of one client 20 in ten seconds are logged and published."""

    def __init__(self, node: Node, error_log: ClientErrorLog) -> None:
        self._node = node
        self._error_log = error_log
        self._publisher: Publisher[AccessRefused] | None = None

    def record(self, access: ClientAccess, address: str, op: Operation, error: MissingRightError) -> None:
        """Log and publish that *op* of the client at *address* was refused with *error*."""
        held_back = self._error_log.log(
            f"rights of {access.issuer}",
            "door.right_missing",
            f"{access.issuer} ({address}): {operation_text(op.op, op.name)} was refused: {error}",
            client=access.issuer,
            address=address,
            op=op.op,
            target=op.name,
            right=error.right.value,
        )
        if held_back is None:
            return

        if self._publisher is None:
            self._publisher = self._node.create_publisher(AccessRefused, ACCESS_REFUSALS, _QOS)
        subject, wanted = access.command_in(op)
        self._publisher.publish(
            AccessRefused(
                issuer=access.issuer,
                address=address,
                operation=op.op,
                target=short_text(op.name, _LONGEST_NAME),
                right=error.right.value,
                reason=str(error),
                refused_at=Time.from_seconds(self._node.graph.clock.now()),
                held_back=held_back,
                subject=subject,
                wanted=wanted,
            )
        )


def operation_text(op: str, name: str) -> str:
    """Return an operation in words, such as ``publishing on /t``; an operation without a name stays as it is."""
    return f"{_DEEDS.get(op, op)} {short_text(name, _SHOWN)}" if name else op
