"""Apps as nodes of the graph, with their settings and stores."""

from __future__ import annotations

from collections import deque
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, final

import anyio
from anyio.abc import TaskStatus

from homebot.apps import App, AppContext
from homebot.apps.created_tasks import APP_NODE
from homebot.clock import Clock, LoopClock
from homebot.config import Urgency
from homebot.devices.health import Count
from homebot.devices.house_view import HouseView
from homebot.feature import plugin_tables
from homebot.graph import Graph, Node
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.support.counters import Severity
from homebot.support.isolation import run_as
from homebot.support.production_loop import is_ours_or_the_users

if TYPE_CHECKING:
    import asyncio
    from collections.abc import AsyncIterator, Callable, Iterable, Iterator, MutableMapping
    from types import FrameType

    from homebot.apps.notifier import Notifier, NotifySettings
    from homebot.apps.stores import AppStores
    from homebot.feature_context import AppKeeper

STORE_FILE = "apps.sqlite"
"""The name of the file of the app stores, beside the index file."""

_MAX_REHEARSED = 10_000


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


def table_of(kind: type[object]) -> str:
    """Return the key of the array of tables that configures apps of the class *kind*; empty for ``[apps.NAME]``."""
    return plugin_tables().get(f"{kind.__module__}:{kind.__qualname__}", "")


@final
class AppHost:
    """The surroundings of apps: nodes, context and stores.

    Args:
        plan: Contains the zone and the location of the home, and the settings of notifications.
        file: The file of the app stores; None for none.
        keepers: Returns the features that keep apps, each with the word for these.
        rehearses: Whether robots are not sent, as in a replay or dry run.

    Attributes:
        began_at: The time before anything started, in seconds since the Unix epoch.
        left_out: The mistakes of the routines, groups and scenes of the configuration that are not in force, by key.
        misspelt_at_end: Unknown names in the queries of each app that has ended.
        rehearsed: The newest acts of robots that were not sent.
    """

    def __init__(
        self,
        graph: Graph,
        plan: Plan,
        file: Path | None,
        clock: Clock,
        keepers: Callable[[], Iterable[tuple[str, AppKeeper]]],
        *,
        rehearses: bool = False,
    ) -> None:
        self._graph = graph
        self.keepers = keepers
        self._file = file
        self._clock = clock
        self.began_at = clock.now()
        self.grants = plan.grants
        self._notify_settings = plan.notify
        self._notifier: Notifier | None = None
        self._main: Node
        self._stores: AppStores | None = None
        self.running: dict[str, App] = {}
        self.misspelt_at_end: dict[str, tuple[str, ...]] = {}
        self.left_out = plan.left_out
        self.rehearsed: deque[RehearsedAct] = deque(maxlen=_MAX_REHEARSED)
        self.context = AppContext(
            plan.home_settings.zone,
            plan.home_settings.latitude,
            plan.home_settings.longitude,
            store_of=lambda app: self._app_stores().of(app),
            keeps_values=lambda: self._stores is not None,
            notify=self._notify,
            notifies=lambda: self._notify_settings is not None,
            not_sent_because=lambda: self.notifier.trouble,
            rehearse=self._rehearse if rehearses else None,
            write_stores=self.write_stores,
            asleep=clock.asleep if isinstance(clock, LoopClock) else float,
            began_at=self.began_at,
        )

    @property
    def notifier(self) -> Notifier:
        """The sender of notifications."""
        if self._notifier is None:
            from homebot.apps.notifier import Notifier  # noqa: PLC0415 - few apps notify

            self._notifier = Notifier(self._main, self._notify_settings)
        return self._notifier

    def send_by(self, settings: NotifySettings | None) -> None:
        """Send notifications by *settings* from now on; without any they are only logged."""
        self._notify_settings = settings
        if self._notifier is not None:
            self._notifier.send_by(settings)

    def wrong_apps(self, table: str = "") -> dict[str, str]:
        """Return why apps of the array *table* of a feature do not run, by name; of all arrays by default."""
        arrays = {table} if table else {*plugin_tables().values()}
        keys = ((key.partition("."), str(mistake)) for key, mistake in self.left_out.items())
        return {app: text for (array, _, app), text in keys if array in arrays and app not in self.running}

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
            self.misspelt_at_end.pop(component.name, None)
            try:
                await run_as(node.full_name, partial(app.serve, task_status=task_status))
                self.misspelt_at_end[component.name] = await HouseView.of(node).names.finish()
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
        for word, keeper in self.keepers():
            yield from (f"the {word} {app} does not run: {problem}" for app, problem in keeper.problems.items())
        arrays = {*plugin_tables().values()}
        for key, mistake in self.left_out.items():
            array, _, app = key.partition(".")
            if array not in arrays:
                yield f"left out: {mistake}"
            elif app not in self.running:
                yield f"the {array.removesuffix('s')} {app} does not run: {mistake}"

    async def unknown_names(self) -> AsyncIterator[str]:
        """Yield the queries of apps whose names nothing in the house has."""
        for word, keeper in self.keepers():
            for name, hints in (await keeper.hints()).items():
                for hint in hints:
                    yield f"the {word} {name}: {hint}"
        for app in tuple(self.running.values()):
            if not table_of(type(app)):
                for problem in await HouseView.of(app.node).names.problems():
                    yield f"{app.node.name}: {problem}"
        for name, problems in self.misspelt_at_end.items():
            for problem in problems:
                yield f"{name}: {problem}"

    def given_up(self) -> set[tuple[str, str]]:
        """Return the node and the callback of each job and handler that was given up."""
        apps = self.running.values()
        runs = ((app, run) for app in apps for run in (*(job.runs for job in app.jobs), *app.given_up))
        return {(app.node.full_name, run.title) for app, run in runs if run.trouble}

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
