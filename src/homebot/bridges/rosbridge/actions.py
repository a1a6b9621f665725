"""The actions of one client: the goals that it sends, and those that it executes."""

from __future__ import annotations

from collections.abc import Callable

from anyio.abc import TaskGroup

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    ActionFeedback,
    ActionOperation,
    ActionResult,
    AdvertiseAction,
    CancelActionGoal,
    SendActionGoal,
    UnadvertiseAction,
)
from homebot.bridges.rosbridge.provided_actions import ProvidedActions
from homebot.bridges.rosbridge.sent_goals import SentGoals
from homebot.bridges.rosbridge.shared_state import SharedState

__all__ = ["ClientActions"]


class ClientActions:
    """Carries out the operations of one connection that are about actions. Made with the first of them.

    Args:
        shared: State shared with other clients.
        access: The client's identity.
        outbox: Takes frames to the client.
        tasks: Where goals are waited for.
        on_taken: Called with the name of an action that a newer connection took over.
    """

    def __init__(
        self,
        shared: SharedState,
        access: ClientAccess,
        outbox: Outbox,
        tasks: TaskGroup,
        on_taken: Callable[[str], None],
    ) -> None:
        node, limit = shared.node, shared.settings.max_calls
        self._sent = SentGoals(node, access, limit, outbox, tasks, shared.counters)
        self._provided = ProvidedActions(node, access.name, limit, outbox, shared.providers, on_taken)

    def __len__(self) -> int:
        """Return the number of actions that the client serves."""
        return len(self._provided)

    @property
    def goals(self) -> int:
        """The number of goals that the client sent and that have not ended."""
        return len(self._sent)

    def handle(self, op: ActionOperation) -> None:
        """Carry out *op*.

        Raises:
            HomebotError: It is refused.
        """
        match op:
            case SendActionGoal():
                self._sent.send(op)
            case CancelActionGoal():
                self._sent.cancel(op)
            case ActionFeedback():
                self._provided.publish_feedback(op)
            case ActionResult():
                self._provided.end(op)
            case AdvertiseAction():
                self._provided.advertise(op)
            case UnadvertiseAction():
                self._provided.unadvertise(op)

    def close_one(self) -> bool:
        """Cancel the goals of an action, or withdraw one; return whether there was one."""
        return self._sent.close_one() or self._provided.close_one()
