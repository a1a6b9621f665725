"""A dry run: gateways only observe, on nodes that receive no commands."""

from typing import Any, ClassVar, Final, TypeVar, final

from pydantic import ValidationError

from homebot.apps.grants import ACT
from homebot.config import Config
from homebot.control.command import IssuedCommand
from homebot.devices.names import GATEWAY_READING, SENDS_NOTHING
from homebot.devices.outcomes import Confirmed, Evidence, Outcome, Refused
from homebot.errors import RefusedError
from homebot.graph import Graph, Node, Service, Subscription
from homebot.graph.mailbox import BoundedQueue
from homebot.graph.qos import QoSLike
from homebot.graph.service import Handler
from homebot.graph.subscription import Callback, Expiring
from homebot.messages.message import Message, ServiceType

MessageT = TypeVar("MessageT", bound=Message)
RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT")

DRY_RUN: Final = "dry_run"
"""The name of the policy that refuses the commands of people in a dry run."""


def observing(config: Config) -> Config:
    """Return *config* with gateways that only observe."""
    gateways = {name: {**table, ACT: False} for name, table in config.gateways.items()}
    return config.model_copy(update={"gateways": gateways})


@final
class DryRun:
    """A dry run: nothing is sent.

    An app continues as if the device had obeyed, until the next report. A person gets a refusal.
    """

    is_live: ClassVar[bool] = True

    def outcome(self, command: IssuedCommand) -> Outcome:
        """See :class:`homebot.control.sending.SimulatedExecution`."""
        if command.is_client:
            problem = "homebot runs with --dry-run and sends nothing; otherwise it would have sent this"
            return Refused(DRY_RUN, problem, command_id=command.id)
        return Confirmed(0.0, Evidence.SENT, command_id=command.id)


@final
class MutedNode(Node):
    """The node of a gateway that cannot receive commands, even if the gateway ignores `act`.

    It receives nothing on topics below its own name, such as raw commands and exposed devices. Its services refuse all
    calls, except read-only services (:data:`homebot.devices.names.GATEWAY_READING`).
    """

    def __init__(self, graph: Graph, name: str) -> None:
        super().__init__(graph, name, namespace="/gateway")

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callback[MessageT] | None = None,
        qos_profile: QoSLike = 10,
        *,
        concurrent: bool = False,
        from_node: str = "",
        queue: BoundedQueue[MessageT | Expiring[MessageT]] | None = None,
        names_sender: bool = False,
    ) -> Subscription[MessageT]:
        """Return a subscription, see :class:`Node`; on a topic below the node's own name it receives nothing."""
        if self.resolve_name(topic).startswith(f"{self.full_name}/"):
            queue = _Nothing()
        return super().create_subscription(
            msg_type,
            topic,
            callback,
            qos_profile,
            concurrent=concurrent,
            from_node=from_node,
            queue=queue,
            names_sender=names_sender,
        )

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: Handler[RequestT, ResponseT],
        *,
        concurrent: bool = False,
        cancel_with_caller: bool = False,
    ) -> Service[RequestT, ResponseT]:
        """Serve *srv_name*, see :class:`Node`; unless it is read-only, it refuses every call."""
        name = self.resolve_name(srv_name, "service name")
        if name.rpartition("/")[2] not in GATEWAY_READING:
            callback = _refusal(srv_type, name)
        return super().create_service(
            srv_type, srv_name, callback, concurrent=concurrent, cancel_with_caller=cancel_with_caller
        )


class _Nothing:
    """A queue that discards every item, so that publishers find their subscriber and never wait for it."""

    def append(self, _: object, /) -> None:
        """Discard an item."""

    def popleft(self) -> Any:
        """Raise LookupError, because there is never an item."""
        raise LookupError("it is empty")

    def has_room_for(self, _: object, /) -> bool:
        """Return True."""
        return True

    def __len__(self) -> int:
        return 0


def _refusal(srv_type: ServiceType[RequestT, ResponseT], name: str) -> Handler[RequestT, ResponseT]:
    """Return a handler that refuses every call, in the response if that of *srv_type* has the usual fields."""
    said = {"success": False, "message": SENDS_NOTHING, "problem": "refused"}
    response: Any = srv_type.Response  # a message

    def refuse(_: RequestT) -> ResponseT:
        refused = RefusedError(f"a call of {name}", SENDS_NOTHING)
        if not {"success", "message"} <= response.model_fields.keys():
            raise refused
        try:
            answer: ResponseT = response.model_validate(
                {key: said[key] for key in said if key in response.model_fields}
            )
        except ValidationError:
            raise refused from None
        return answer

    return refuse
