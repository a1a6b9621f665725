"""Apps as nodes of the graph, with their settings and stores."""

from __future__ import annotations

import sys
from collections import deque
from contextlib import suppress
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, final

import anyio
from anyio.abc import TaskStatus

from homebot.apps import App, AppContext
from homebot.apps.created_tasks import APP_NODE
from homebot.apps.grants import queries_of
from homebot.clock import Clock, LoopClock
from homebot.config import Config, Urgency
from homebot.devices.client_rights import EDIT_ROUTINE
from homebot.devices.health import Count
from homebot.devices.house_view import HouseView
from homebot.errors import ConfigError
from homebot.graph import Graph, Node
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.support.counters import Severity
from homebot.support.isolation import run_as
from homebot.support.production_loop import is_ours_or_the_users

if TYPE_CHECKING:
    import asyncio
    from collections.abc import AsyncIterator, Callable, Collection, Iterator, Mapping, MutableMapping
    from types import FrameType

    from homebot.apps.notifier import Notifier
    from homebot.apps.stores import AppStores
    from homebot.control import Control
    from homebot.routines.checks import HouseChecks
    from homebot.routines.effects import Effect
    from homebot.routines.routine import Routine
    from homebot.runtime.kept_routines import KeptRoutines

STORE_FILE = "apps.sqlite"
"""The name of the file of the app stores, beside the index file."""

_MOST_REHEARSED = 10_000
_ROUTINES = "routines."
_ROUTINE_MODULE = "homebot.routines.routine"
_KEPT_ROUTINES = "routines"
IDENTIFY_VALUES = "identify/values"
"""The names of stores that no app can have."""


class RehearsedAct(NamedTuple):
    """An act of a robot that was not sent.

    Attributes:
        at: Seconds since the Unix epoch.
        app: The name of the app.
        text: The act, such as ``rosie go to kitchen``.
    """

    at: float
    app: str
    text: str


@final
class AppHost:
    """The surroundings of apps: nodes, context and stores.

    Args:
        plan: Contains the zone and the location of the home, and the settings of notifications.
        file: The file of the app stores; None for none.
        rehearses: Whether robots are not sent, as in a replay or dry run.

    Attributes:
        began_at: The time before anything started, in seconds since the Unix epoch.
        left_out: The mistakes of the routines, groups and scenes of the configuration that are not in force, by key.
        rehearsed: The newest acts of robots that were not sent.
    """

    def __init__(
        self,
        graph: Graph,
        plan: Plan,
        file: Path | None,
        clock: Clock,
        control: Callable[[], Control | None],
        *,
        rehearses: bool = False,
    ) -> None:
        self._graph = graph
        self._control = control
        self._file = file
        self._clock = clock
        self.began_at = clock.now()
        self._grants, self._tables = plan.grants, plan.tables
        self._notify_settings = plan.notify
        self._notifier: Notifier | None = None
        self._main: Node
        self._stores: AppStores | None = None
        self.running: dict[str, App] = {}
        self.left_out = plan.left_out
        self.rehearsed: deque[RehearsedAct] = deque(maxlen=_MOST_REHEARSED)
        self.context = AppContext(
            plan.home_settings.zone,
            plan.home_settings.latitude,
            plan.home_settings.longitude,
            store_of=lambda app: self._app_stores().of(app),
            keeps_values=lambda: self._stores is not None,
            notify=self._notify,
            notifies=plan.notify is not None,
            rehearse=self._rehearse if rehearses else None,
            write_stores=self.write_stores,
            asleep=clock.asleep if isinstance(clock, LoopClock) else float,
        )

    @property
    def notifier(self) -> Notifier:
        """The sender of notifications."""
        if self._notifier is None:
            from homebot.apps.notifier import Notifier  # noqa: PLC0415 - few apps notify

            self._notifier = Notifier(self._main, self._notify_settings)
        return self._notifier

    @property
    def wrong_routines(self) -> dict[str, str]:
        """The problems of the routines of the configuration that do not run, by the names of their apps."""
        wrong = {
            key.removeprefix(_ROUTINES): str(one) for key, one in self.left_out.items() if key.startswith(_ROUTINES)
        }
        return {app: problem for app, problem in wrong.items() if app not in self.running}

    @property
    def routines(self) -> dict[str, Routine]:
        """The running routines, by the name of the app."""
        if _ROUTINE_MODULE not in sys.modules:
            return {}
        from homebot.routines.routine import Routine  # noqa: PLC0415 - there are some

        return {name: one for name, one in tuple(self.running.items()) if isinstance(one, Routine)}

    @cached_property
    def kept_routines(self) -> KeptRoutines:
        """The routines that the owner wrote by a command."""
        from homebot.runtime.kept_routines import KeptRoutines  # noqa: PLC0415 - many homes have none

        return KeptRoutines(self._app_stores().of(_KEPT_ROUTINES), self._grant)

    @property
    def has_kept_routines(self) -> bool:
        """True if there are any."""
        return self._stores is not None and bool(self._stores.of(_KEPT_ROUTINES))

    def store(self, name: str) -> MutableMapping[str, Any]:
        """Return the store of that name, which no app can have."""
        return self._app_stores().of(name)

    def has_kept(self, name: str) -> bool:
        """Return whether anything is in that store."""
        return self._stores is not None and bool(self._stores.of(name))

    async def write_stores(self) -> str:
        """Write all changes now; return the problem, empty for none."""
        if self._stores is None:
            return ""
        await self._stores.flush()
        return self._stores.trouble

    def with_kept_routines(self, config: Config) -> Config:
        """Return *config* with the kept routines, if there are any."""
        return self.kept_routines.added_to(config) if self.has_kept_routines else config

    def grant_kept_routines(self) -> None:
        """Add the rights of the kept routines to those of the configuration."""
        for app in self.kept_routines if self.has_kept_routines else ():
            self._grant(app)

    def _grant(self, app: str) -> None:
        """Bring the rights of a kept routine in line with its text; an app of the configuration keeps its own."""
        node = f"/{app}"
        if not self._tables.get(node, EDIT_ROUTINE).startswith(EDIT_ROUTINE):
            return
        self._grants.pop(node, None)
        self._tables.pop(node, None)
        with suppress(ConfigError):  # a routine with a mistake does not run
            if app in self.kept_routines:
                self._tables[node], scope = self.kept_routines.grants(app)
                self._grants |= {} if scope is None else {node: scope}
        if (control := self._control()) is not None:
            control.forget_rights()

    def queries_granted(self, app: str) -> tuple[str, ...] | None:
        """Return the queries of the key ``act`` of a routine; None if it has none."""
        scope = self._grants.get(f"/{app}")
        return None if scope is None else queries_of(scope)

    async def routines_commanding(self, device: str) -> frozenset[str]:
        """Return the names of the routines that command a device."""
        return await self._checks.commanding((one.settings for one in self.routines.values()), device)

    @cached_property
    def _checks(self) -> HouseChecks:
        from homebot.routines.checks import HouseChecks  # noqa: PLC0415 - many homes have none

        return HouseChecks(self._main, self._refusal, with_robots=self.context.rehearse is None)

    def _refusal(self, app: str, effect: Effect) -> tuple[str, str]:
        """Return why *effect* of *app* is refused for lack of a right or an approval, and that right, as a query."""
        from homebot.control.policies.rights import APPROVAL, OF_RIGHTS  # noqa: PLC0415 - many homes have no routine

        control, part = self._control(), effect.device.part(effect.part)
        if control is None or part is None or effect.may_be:
            return "", ""
        refused = control.preview(effect.request(app), effect.device, part)
        if refused is None or refused.policy not in OF_RIGHTS | {APPROVAL}:
            return "", ""
        return refused.reason, f'id="{effect.device.id}"' if refused.policy in OF_RIGHTS else ""

    async def why_asked(self, routine: Routine) -> Mapping[str, str]:
        """Return why a person must agree to the steps of *routine*, by the names of the parts."""
        from homebot.command_words.suitable_parts import part_name  # noqa: PLC0415 - many homes have no routine

        control, reasons = self._control(), dict[str, str]()
        for effect in await self._checks.effects(routine.settings):
            if control is not None and (part := effect.device.part(effect.part)) is not None:
                reason = await control.why_asked(effect.request(routine.node.name), effect.device, part)
                reasons |= {part_name(effect.device, part): reason} if reason else {}
        return reasons

    async def meant_by(self, query: str) -> str:
        """Return the names of the devices that *query* finds; *query* itself if these are many, or none."""
        return await self._checks.named(query)

    async def read_stores(self, main: Node) -> None:
        """Read the stores of earlier runs; *main* runs the task that writes them."""
        self._main = main
        if self._file is not None and await anyio.Path(self._file).exists():
            await self._app_stores().read()

    async def close_stores(self) -> None:
        """Write pending changes."""
        if self._stores is not None:
            await self._stores.close()

    async def serve(self, component: PlannedComponent[App], *, task_status: TaskStatus[None]) -> None:
        """Run an app in its own node until cancelled."""
        APP_NODE.set(f"/{component.name}")
        async with Node(self._graph, component.name) as node:
            component.offer_settings(node)
            app = component.kind(node, component.settings)
            app.context = self.context
            self.running[component.name] = app
            try:
                await run_as(node.full_name, partial(app.serve, task_status=task_status))
            finally:
                self.running.pop(component.name, None)
                if self._stores is not None:
                    await self._stores.flush()

    def watch_task(self, node: str, creator: FrameType, task: asyncio.Task[Any]) -> None:
        """Let the app of *node* look after *task* if its code or a file beside it is the *creator*, not a library."""
        app = self.running.get(node.removeprefix("/"))
        if app is not None:
            package = type(app).__module__.partition(".")[0]
            if is_ours_or_the_users(creator) or creator.f_globals.get("__name__", "").partition(".")[0] == package:
                app.created_tasks.add(task)

    def counts(self) -> tuple[Count, ...]:
        """Return counters for health reports."""
        if self._notifier is None:
            return ()
        dropped = Count(name="notifications_dropped", count=self._notifier.dropped, severity=Severity.LOSS)
        return dropped, Count(name="notifications_failed", count=self._notifier.failed, severity=Severity.FAULT)

    def problems(self) -> Iterator[str]:
        """Yield why the last notification was not sent, and the trouble of the file of the apps."""
        if self._notifier is not None and self._notifier.trouble:
            yield f"the last notification was not sent: {self._notifier.trouble}"
        if self._stores is not None and self._stores.trouble:
            yield self._stores.trouble
        wrong = dict(self.wrong_routines)
        if self.has_kept_routines:
            wrong |= self.kept_routines.problems
        yield from (f"the routine {app} does not run: {problem}" for app, problem in wrong.items())
        yield from (f"left out: {one}" for key, one in self.left_out.items() if not key.startswith(_ROUTINES))

    async def unknown_names(self) -> AsyncIterator[str]:
        """Yield the queries of apps whose names nothing in the house has."""
        for name, problems in (await self.routine_problems()).items():
            for problem in problems:
                yield f"the routine {name}: {problem}"
        for app in tuple(self.running.values()):
            if app.node.name not in self.routines:
                for problem in await HouseView.of(app.node).names.problems():
                    yield f"{app.node.name}: {problem}"

    async def routine_problems(
        self, names: Collection[str] = (), lacking: dict[str, list[str]] | None = None
    ) -> Mapping[str, list[str]]:
        """Return what in each routine, or those *names*, cannot work in the house as it is now, by its name.

        Args:
            lacking: Filled with the rights that each lacks, as queries.
        """
        routines = self.routines
        if not routines:
            return {}
        settings = (one.settings.model_copy(update={"enabled": one.is_enabled}) for one in routines.values())
        return await self._checks.problems(settings, names, lacking)

    def given_up(self) -> set[tuple[str, str]]:
        """Return the node and the callback of each job and handler that was given up."""
        apps = self.running.values()
        runs = ((app, one) for app in apps for one in (*(job.runs for job in app.jobs), *app.given_up))
        return {(app.node.full_name, one.title) for app, one in runs if one.trouble}

    def _rehearse(self, app: str, text: str) -> None:
        self.rehearsed.append(RehearsedAct(self._clock.now(), app, text))

    async def _notify(self, message: str, title: str, app: str, urgency: Urgency = "normal", kind: str = "") -> bool:
        return await self.notifier.send(message, title, app, self.context.zone, urgency, kind)

    def _app_stores(self) -> AppStores:
        """Return the app stores, which are written from their first use on."""
        if self._stores is None:
            from homebot.apps.stores import AppStores  # noqa: PLC0415 - few apps keep anything

            self._stores = AppStores(self._file, self._clock)
            self._main.create_task(self._stores.run)
        return self._stores
