"""All that one client of the door holds: topics, services, actions, goals and leases."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from anyio.abc import TaskGroup

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.backlog import Backlog
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.provided_services import ProvidedServices, Provisions
from homebot.bridges.rosbridge.publications import Publications
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.bridges.rosbridge.subscriptions import Subscriptions

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.provided_actions import ProvidedActions
    from homebot.bridges.rosbridge.sent_goals import SentGoals

__all__ = ["Holdings"]


class Holdings:
    """Everything that goes when the client goes.

    Args:
        access: The client's identity.
        on_unfit: Called with operation, topic, problem and id where a message or a request turns out wrong later.
        on_taken: Called with the name of a service or action that a newer connection took over.
    """

    def __init__(
        self,
        shared: SharedState,
        access: ClientAccess,
        outbox: Outbox,
        tasks: TaskGroup,
        on_unfit: Callable[[str, str, str, protocol.Identifier], None],
        on_taken: Callable[[str], None],
    ) -> None:
        node, settings = shared.node, shared.settings
        self._shared = shared
        self._access = access
        self._outbox = outbox
        self._tasks = tasks
        self._backlog = backlog = Backlog(settings.max_waiting_bytes, shared.backlog)
        self.publications = Publications(node, access, on_unfit)
        self.subscriptions = Subscriptions(node, settings.queue_depth, backlog, outbox, shared.expected, on_unfit)
        self._provisions = Provisions(access.name, shared.providers, on_taken)
        self._services = ProvidedServices(node, settings.max_calls, outbox, self._provisions)
        self._actions: tuple[SentGoals, ProvidedActions] | None = None

    def __len__(self) -> int:
        return len(self.publications) + len(self.subscriptions) + len(self._provisions)

    @property
    def must_end(self) -> bool:
        """True while the client has a goal or a lease, which ends soon after the client."""
        return bool(self._actions and self._actions[0]) or self._shared.leases.has(self)

    def handle(self, op: protocol.Operation) -> None:
        """Carry out *op* if it is about what the client provides or publishes, or about actions.

        Raises:
            HomebotError: It is refused.
        """
        match op:
            case protocol.Advertise():
                self.publications.advertise(op)
            case protocol.Unadvertise():
                self.publications.unadvertise(op)
            case protocol.UnsubscribeOperation():
                self.subscriptions.unsubscribe(op)
            case protocol.AdvertiseService():
                self._services.advertise(op)
            case protocol.UnadvertiseService():
                self._services.unadvertise(op)
            case protocol.ServiceResponse():
                self._services.answer(op)
            case protocol.ActionOperation():
                self._act(op)

    async def close(self) -> None:
        """Give everything back, a little each time the event loop goes round."""
        self._backlog.close()
        kinds: tuple[Provisions | Publications | Subscriptions | SentGoals, ...]
        kinds = (self._provisions, self.publications, self.subscriptions)
        for kind in kinds if self._actions is None else (self._actions[0], *kinds):
            while kind.close_one():
                await self._shared.turns.turn()
        self._shared.leases.release(self)

    def _act(self, op: protocol.ActionOperation) -> None:
        sent, provided = self._actions = self._actions or self._load_actions()
        match op:
            case protocol.SendActionGoal():
                sent.send(op)
            case protocol.CancelActionGoal():
                sent.cancel(op)
            case protocol.ActionFeedback():
                provided.publish_feedback(op)
            case protocol.ActionResult():
                provided.end(op)
            case protocol.AdvertiseAction():
                provided.advertise(op)
            case protocol.UnadvertiseAction():
                provided.unadvertise(op)

    def _load_actions(self) -> tuple[SentGoals, ProvidedActions]:
        from homebot.bridges.rosbridge import provided_actions, sent_goals  # noqa: PLC0415 - with the first one

        node, limit = self._shared.node, self._shared.settings.max_calls
        sent = sent_goals.SentGoals(self._shared, self._access, self._outbox, self._tasks)
        return sent, provided_actions.ProvidedActions(node, limit, self._outbox, self._provisions)
