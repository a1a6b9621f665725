"""The session with robots and other machines, opened again when its settings or the tokens of its robots change."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Final, NamedTuple, Self, final

import anyio
from anyio import to_thread
from anyio.abc import TaskStatus
from pydantic import SecretStr

from homebot.bridges.zenoh.logins import login_notes, token_of
from homebot.bridges.zenoh.rights import WireRights
from homebot.bridges.zenoh.session import open_session
from homebot.devices.client_rights import OWNER_CLIENT
from homebot.errors import UsageError
from homebot.feature import Feature, all_features, load
from homebot.graph import Graph
from homebot.support.file_access import read_secret
from homebot.support.isolation import run_as, ungrouped
from homebot.support.logger import get_logger

if TYPE_CHECKING:
    from homebot.bridges.rosbridge import ClientToken
    from homebot.bridges.zenoh.current_session import CurrentSession
    from homebot.bridges.zenoh.session import ZenohSession
    from homebot.messages.interfaces.settings import RosSettings
    from homebot.runtime.plan import Plan
    from homebot.support.owner_token import OwnerToken

NOT_LINKED = "ros2.not_linked"
LISTENING = "ros2.listening"
PANICKED = "ros2.panicked"

_AGAIN: Final = 30.0
"""Seconds after which a link that could not be opened again is tried anew."""

_PROBED_EVERY: Final = 30.0
"""Seconds between two questions whether Zenoh has panicked in a thread of its own."""

_log = get_logger(node="/homebot")


class OpenSession(NamedTuple):
    """The session of ``[ros]``, for features that use it.

    Attributes:
        plan: The plan in force when it was opened.
        settings: The settings of the plan, without robots that have lost their tokens.
    """

    graph: Graph
    plan: Plan
    settings: RosSettings
    session: ZenohSession


@final
class SessionKeeper:
    """Keeps the session of the plan that is in force, and runs the features that use it.

    Args:
        current: Gets the session, for gateways.
        plan: Returns that plan.
        owner: Returns the owner's token; None without one.
    """

    def __init__(
        self,
        graph: Graph,
        current: CurrentSession,
        plan: Callable[[], Plan],
        owner: Callable[[], Awaitable[OwnerToken | None]],
    ) -> None:
        self._graph, self._current, self._plan, self._owner = graph, current, plan, owner
        self._facts: _Facts | None = None
        self._is_first = True
        self._changed = anyio.Event()

    def reload(self) -> None:
        """Begin the link again if the plan has changed the facts on which it depends."""
        if self._facts is not None and self._facts != _Facts.of(self._plan()):
            self._changed.set()

    async def serve(self, *, task_status: TaskStatus[None]) -> None:
        """Run until cancelled; a mistake in a later plan is logged, and leaves no link until it is mended.

        Raises:
            UsageError: The link cannot be started as configured.
        """
        is_started = False
        while True:
            self._changed, plan = anyio.Event(), self._plan()
            self._facts = _Facts.of(plan)
            settings = plan.link if self._is_first else self._facts.settings
            longest = self._facts.seconds_to_an_end(self._graph.clock.now())
            async with anyio.create_task_group() as tasks:
                try:
                    if settings is not None:
                        await tasks.start(self._run, plan, settings)
                except UsageError as exc:
                    if self._is_first:
                        raise
                    _log.error(NOT_LINKED, message=f"there is no link to robots: {exc}; trying again")
                    longest = _AGAIN
                self._is_first = False
                if not is_started:
                    task_status.started()
                    is_started = True
                with anyio.move_on_after(longest):
                    await self._changed.wait()
                tasks.cancel_scope.cancel()

    async def _run(self, plan: Plan, settings: RosSettings, *, task_status: TaskStatus[None]) -> None:
        now, owner = self._graph.clock.now(), await self._owner()
        secret = None if owner is None else SecretStr(owner.secret)
        rights = await to_thread.run_sync(read_rights, plan, settings, now, secret)
        async with open_session(settings, rights) as session:
            opened = OpenSession(self._graph, plan, settings, session)
            self._current.session = session
            if settings.listen and not settings.connect:
                users = ", ".join(rights.passwords) or "nobody"
                told = f"router for robots listening on {settings.listen}; may log in: {users}"
                _log.info(LISTENING, message="; ".join([told, *login_notes(settings, plan.door)]))
            try:
                with ungrouped(UsageError):
                    async with anyio.create_task_group() as tasks:
                        tasks.start_soon(run_as, "the session of [ros]", session.run)
                        tasks.start_soon(self._begin_again_after_panic, session)
                        for feature in all_features():
                            if feature.over_zenoh:
                                await tasks.start(_serve_feature, feature, opened)
                        task_status.started()
            finally:
                self._current.session = None

    async def _begin_again_after_panic(self, session: ZenohSession) -> None:
        while not session.panicked.is_set():
            session.probe()
            with anyio.move_on_after(_PROBED_EVERY):
                await session.panicked.wait()
        _log.error(PANICKED, message="Zenoh panicked: the link to robots begins again")
        self._changed.set()


async def _serve_feature(feature: Feature, opened: OpenSession, *, task_status: TaskStatus[None]) -> None:
    serve = partial(load(feature.over_zenoh), opened, task_status=task_status)
    await run_as(f"/{feature.name}", serve)


class _Facts(NamedTuple):
    """The facts on which a link depends.

    Attributes:
        settings: The settings without robots whose tokens were revoked; None for no link.
        owner: The token of the owner in the configuration.
        tokens: The tokens of the robots.
    """

    settings: RosSettings | None
    owner: SecretStr | None = None
    tokens: tuple[ClientToken, ...] = ()

    @classmethod
    def of(cls, plan: Plan) -> Self:
        if plan.link is None:
            return cls(None)
        names = {robot: token_of(robot, plan.door) for robot in plan.link.imports}
        known = {robot: plan.link.imports[robot] for robot, name in names.items() if name is not None}
        tokens = tuple(plan.door.tokens[name] for name in names.values() if name is not None)
        return cls(plan.link.model_copy(update={"imports": known}), plan.door.token, tokens)

    def seconds_to_an_end(self, now: float) -> float:
        """Return the seconds until one of the tokens ends."""
        return min((token.until for token in self.tokens if token.until > now), default=inf) - now


def read_rights(plan: Plan, settings: RosSettings, now: float, owner: SecretStr | None) -> WireRights:
    """Return the rights of others in a session with *settings*, which may be other than those of *plan*. Blocking.

    Raises:
        UsageError: A secret cannot be read.
    """
    own = SecretStr(read_secret(settings.password_file)) if settings.password_file is not None else None
    if settings.connect:
        return WireRights.of_routers(settings, plan.home, _login(settings, own, owner))
    machines = {name: SecretStr(read_secret(file)) for name, file in plan.other_machines.items()}
    if own is not None and settings.machine:
        machines[settings.machine] = own
    return WireRights.of_tokens(settings, plan.door, plan.home, machines, now, owner)


def _login(settings: RosSettings, own: SecretStr | None, owner: SecretStr | None) -> tuple[str, SecretStr] | None:
    if own is not None:
        return settings.user or settings.machine, own
    return (OWNER_CLIENT, owner) if settings.listen and owner is not None else None
