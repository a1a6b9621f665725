"""A client of the rosbridge server: its rights, and the log of its mistakes."""

from typing import Final

from homebot.bridges.client_error_log import short_text
from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
from homebot.bridges.rosbridge.protocol import Operation
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.devices.access_messages import AccessRefused
from homebot.devices.names import ACCESS_REFUSALS
from homebot.graph import QoSProfile
from homebot.messages import Time

_QOS: Final = QoSProfile(depth=100)
_MAX_NAME: Final = 247
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


class OutsideClient:
    """A connection, or a request to the HTTP API."""

    def __init__(self, shared: SharedState, access: ClientAccess, address: str) -> None:
        self.refused = 0
        self.shared = shared
        self.access = access
        self.address = address

    def log(self, kind: str, event: str, text: str, **facts: str | int) -> None:
        """Log *text* after the name of the client, at a limited rate per *kind* and host."""
        kind, line = f"{kind} {self.address.rpartition(':')[0]}", f"{self.access.issuer} ({self.address}){text}"
        self.shared.error_log.log(kind, event, line, level="warning", error=None, client=self.address, **facts)

    def log_refusal(self, text: str, op: str, problem: str, event: str = "door.refused") -> None:
        """Count and log a refused frame or request."""
        self.refused += 1
        self.shared.counters.requests_refused += 1
        self.log("refused", event, text, op=op, problem=problem, refused=self.refused)

    def record_missing_right(self, op: Operation, error: MissingRightError) -> None:
        """Count, log and publish that *op* was refused for lack of a right: at most 20 per client in ten seconds."""
        shared, issuer = self.shared, self.access.issuer
        self.refused += 1
        shared.counters.requests_refused += 1
        shared.counters.rights_missing += 1
        held_back = shared.error_log.log(
            f"rights of {issuer}",
            "door.right_missing",
            f"{issuer} ({self.address}): {operation_text(op.op, op.name)} was refused: {error}",
            client=issuer,
            address=self.address,
            op=op.op,
            target=op.name,
            right=error.right.value,
        )
        if held_back is None:
            return
        if shared.refusals is None:
            shared.refusals = shared.node.create_publisher(AccessRefused, ACCESS_REFUSALS, _QOS)
        subject, wanted = self.access.command_in(op)
        shared.refusals.publish(
            AccessRefused(
                issuer=issuer,
                address=self.address,
                operation=op.op,
                target=short_text(op.name, _MAX_NAME),
                right=error.right.value,
                reason=str(error),
                refused_at=Time.from_seconds(shared.node.graph.clock.now()),
                held_back=held_back,
                subject=subject,
                wanted=wanted,
            )
        )


def operation_text(op: str, name: str) -> str:
    """Return an operation in words, such as ``publishing on /t``; unchanged without a name."""
    return f"{_DEEDS.get(op, op)} {short_text(name, _SHOWN)}" if name else op
