"""The actions of one client: the goals that it sends, and those that it executes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from anyio.abc import TaskGroup

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.provided_actions import ProvidedActions
from homebot.bridges.rosbridge.provisions import Provisions
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
        provisions: The servers of the client.

    Attributes:
        sent: The goals that the client sent.
    """

    def __init__(
        self, shared: SharedState, access: ClientAccess, outbox: Outbox, tasks: TaskGroup, provisions: Provisions
    ) -> None:
        self.sent = SentGoals(shared, access, outbox, tasks)
        provided = ProvidedActions(shared.node, shared.settings.max_calls, outbox, provisions)
        self._handlers: dict[type[protocol.Operation], Callable[[Any], None]] = {
            protocol.SendActionGoal: self.sent.send,
            protocol.CancelActionGoal: self.sent.cancel,
            protocol.ActionFeedback: provided.publish_feedback,
            protocol.ActionResult: provided.end,
            protocol.AdvertiseAction: provided.advertise,
            protocol.UnadvertiseAction: provided.unadvertise,
        }

    def handle(self, op: protocol.ActionOperation) -> None:
        """Carry out *op*; ``action_status``, which the server of the action knows, is ignored.

        Raises:
            HomebotError: It is refused.
        """
        handler = self._handlers.get(type(op))
        if handler is not None:
            handler(op)
