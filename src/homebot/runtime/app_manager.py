"""Apps while homebot runs: started with it, and loaded, unloaded and reloaded later."""

from __future__ import annotations

import asyncio
import gc
import math
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from itertools import count, islice
from typing import TYPE_CHECKING, TypeAlias, final

import anyio
from anyio import to_thread
from anyio.abc import TaskGroup, TaskStatus

from homebot.apps import App
from homebot.apps.created_tasks import watch_created_tasks
from homebot.clock import zone_name
from homebot.devices.app_messages import (
    AppInfo,
    AppJob,
    AppsRequest,
    AppsResponse,
    ChangeAppRequest,
    ChangeAppResponse,
    GetHomePlace,
    HomePlaceRequest,
    HomePlaceResponse,
    ListApps,
    LoadApp,
    ReloadApp,
    UnloadApp,
)
from homebot.devices.names import (
    HOME_PLACE,
    LIST_APPS,
    LOAD_APP,
    RELOAD_APP,
    UNLOAD_APP,
)
from homebot.errors import HomebotError, UsageError
from homebot.graph import Node
from homebot.messages import Time
from homebot.plugins import plugin_names
from homebot.runtime.app_host import AppHost, table_of
from homebot.runtime.plan import APPS, PlannedComponent
from homebot.runtime.supervisor import ComponentCrashes, Supervisor
from homebot.support.isolation import error_text
from homebot.support.logger import get_logger
from homebot.support.names import did_you_mean

if TYPE_CHECKING:
    from homebot.apps.jobs import Job
    from homebot.config import Config
    from homebot.runtime.app_loading import AppPlanner, FreshCode

LEFT_OUT = "app.left_out"
LOADED = "app.loaded"
UNLOADED = "app.unloaded"
RELOADED = "app.reloaded"
NOT_RELOADED = "app.not_reloaded"
NOT_ENDED = "app.not_ended"
_MAX_LISTED = 20
"""The limit of listed handlers of an app that were given up, and of devices that it waits for to stay as they are."""

_TRIAL = 1.0
"""Seconds after the start in which a crash of the new code restores the old."""

_ENDS_WITHIN = 3.0
"""Seconds in which an app that is cancelled must end, before homebot must; then its code is closed."""

_CLOSED_WITHIN = 1.0

_DATA_TRIAL = 0.02
"""The same for an app of a table of a feature, which has no code of its own: it has begun then."""

_COLLECT_EVERY = 100
"""Reloads after which old code is freed: classes are cycles, and a process that serves collects all objects too seldom.
That takes less than a second in a house of a thousand devices."""

PlannedApp: TypeAlias = "PlannedComponent[App]"
_log = get_logger(node="/homebot")


@dataclass(slots=True)
class _RunningApp:
    planned: PlannedApp
    is_stopped: anyio.Event = field(default_factory=anyio.Event)
    has_ended: anyio.Event = field(default_factory=anyio.Event)
    has_crashed: anyio.Event = field(default_factory=anyio.Event)
    crash: str = ""
    problem: str = ""


@final
class AppManager:
    """Starts, stops and replaces apps, one at a time.

    Args:
        planner: Plans apps that are loaded or reloaded.

    Attributes:
        trial: Seconds for which new code must run without a crash.
        ends_within: Seconds in which an app that is stopped must end.
    """

    def __init__(self, supervisor: Supervisor, host: AppHost, planner: AppPlanner) -> None:
        self._supervisor = supervisor
        self._host = host
        self._planner = planner
        self._apps: dict[str, _RunningApp] = {}
        self._turn = anyio.Lock()
        self._tasks: TaskGroup | None = None
        self._reloads = count(1)
        self.running_apps: Mapping[str, App] = host.running
        self.grants = host.grants
        self.wrong_apps = host.wrong_apps
        self.trial = _TRIAL
        self.ends_within = _ENDS_WITHIN

    @property
    def apps(self) -> tuple[PlannedApp, ...]:
        """The apps, in the order of their start."""
        return tuple(app.planned for app in self._apps.values())

    @asynccontextmanager
    async def running(self, planned: Iterable[PlannedApp], is_cut: Callable[[], bool]) -> AsyncIterator[None]:
        """Start *planned*, each when the previous one is ready; at the end, stop all in reverse order.

        Raises:
            UsageError: An app cannot be started as configured.
        """
        mistake = None
        loop = asyncio.get_running_loop()
        factory = loop.get_task_factory()
        async with anyio.create_task_group() as tasks:
            self._tasks = tasks
            try:
                for planned_app in planned:
                    if not is_cut():
                        await self._start(planned_app)
                if not is_cut():
                    await self._start_kept()
                for problem in self._host.problems():
                    _log.warning(LEFT_OUT, message=problem)
            except UsageError as exc:
                mistake = exc
            else:
                yield
            self._tasks = None
            for app in reversed(tuple(self._apps.values())):
                await self._stop(app)
            tasks.cancel_scope.cancel()
            loop.set_task_factory(factory)
        if mistake is not None:
            raise mistake

    async def load(self, *names: str) -> str:
        """Start apps from the configuration, an installed package or a file, all or none; return a text for people.

        Raises:
            HomebotError: One is already running, cannot be loaded, or crashes at once; names the reason.
        """
        loaded: list[tuple[PlannedApp, FreshCode]] = []
        async with self._turn:
            try:
                config = await self._read_config()
                for name in names:
                    planned, code = await self._plan(name, config, is_new=True)
                    if planned.name in self._apps:
                        code.restore()
                        advice = f"`homebot app reload {planned.name}` reloads it"
                        raise UsageError(f"the app {planned.name} is already running; {advice}")
                    loaded.append((planned, code))
                    await self._begin(planned)
                crashed, problem = await self._first_crash([planned.name for planned, _ in loaded])
                if crashed:
                    raise UsageError(f"{crashed} is not loaded: {problem}")
            except HomebotError:
                for planned, code in loaded:
                    await self._remove(planned.name)
                    code.restore()
                raise
            texts = [self._report(LOADED, f"loaded the app {app.name}", app.name) for app, _ in loaded]
            return "; ".join(texts)

    async def unload(self, name: str) -> str:
        """Stop the app *name*; return a text for people.

        Raises:
            UsageError: There is none, or it swallowed its cancellation.
        """
        async with self._turn:
            app = self._find(name)
            await self._remove(app.planned.name)
            if app.problem:
                raise UsageError(app.problem)
            return self._report(UNLOADED, f"unloaded the app {name}", name)

    async def reload(self, name: str) -> str:
        """Restart the app *name* with its current code and settings; return a text for people.

        Raises:
            UsageError: There is none, or the new code cannot be loaded or crashes at once; the old one keeps running.
        """
        async with self._turn:
            if not next(self._reloads) % _COLLECT_EVERY:
                gc.collect()
            old = self._find(name).planned
            try:
                planned, code = await self._plan(name, await self._read_config(), is_new=False)
            except HomebotError as exc:
                raise self._failure(name, str(exc)) from exc
            position = list(self._apps)
            await self._stop(self._apps[name])
            if problem := await self._try(planned):
                await self._stop(self._apps[name])
                code.restore()
                await self._try(old)
            self._apps = {app_name: self._apps[app_name] for app_name in position}
            if problem:
                raise self._failure(name, problem)
            return self._report(RELOADED, f"reloaded the app {name}", name)

    async def reload_changed(self, *, task_status: TaskStatus[None]) -> None:
        """Reload each app when its file changes, until cancelled."""
        module = await to_thread.run_sync(import_module, "homebot.runtime.app_watch")  # needs an extra
        await module.reload_changed_apps(self.apps, self.reload, task_status=task_status)

    def running_text(self, planned: Iterable[PlannedApp]) -> str:
        """Return a text for people that names the apps of *planned* that run after the start."""
        names = [app.name for app in planned]
        if not names:
            installed = ", ".join(plugin_names(APPS)) or "none"
            return f"no app is running; add one with --app NAME or a table [apps.NAME] (installed: {installed})"
        down = {name for name, crash in self._supervisor.crashes.items() if crash.state != "running again"}
        crashed = [name for name in names if name in down]
        running = [name for name in names if name not in crashed]
        if not running:
            return f"no app is running yet: {', '.join(crashed)} crashed at the start"
        names = running
        return f"running the app {names[0]}" if len(names) == 1 else f"running the apps {', '.join(names)}"

    def offer_services(self, node: Node) -> None:
        """Offer the services for clients on *node*."""
        node.create_service(LoadApp, LOAD_APP, partial(_answer, self.load))
        node.create_service(UnloadApp, UNLOAD_APP, partial(_answer, self.unload))
        node.create_service(ReloadApp, RELOAD_APP, partial(_answer, self.reload))
        node.create_service(ListApps, LIST_APPS, self._list)
        node.create_service(GetHomePlace, HOME_PLACE, self._place)

    def _list(self, _: AppsRequest) -> AppsResponse:
        running, crashes = self._host.running, self._supervisor.crashes
        infos = tuple(_info(name, running.get(name), crashes.get(name)) for name in self._apps)
        return AppsResponse(apps=infos, zone=zone_name(self._host.context.zone_name))

    def _place(self, _: HomePlaceRequest) -> HomePlaceResponse:
        place = self._host.context.latitude, self._host.context.longitude
        return HomePlaceResponse(place=tuple(round(coordinate, 1) for coordinate in place if coordinate is not None))

    async def _start_kept(self) -> None:
        """Start the apps that features keep; a wrong one stays out."""
        config: Config | None = None
        for _, keeper in self._host.keepers():
            for app in keeper.kept_apps():
                try:
                    config = config or await self._read_config()
                    planned, _ = await self._plan(app, config, is_new=True)
                    if app not in keeper.problems:
                        await self._start(planned)
                except HomebotError as exc:
                    keeper.problems.setdefault(app, str(exc))

    async def _read_config(self) -> Config:
        return await to_thread.run_sync(self._planner.read)

    async def _plan(self, name: str, config: Config, *, is_new: bool) -> tuple[PlannedApp, FreshCode]:
        return await to_thread.run_sync(partial(self._planner.plan, name, config, is_new=is_new))

    def _find(self, name: str) -> _RunningApp:
        if (app := self._apps.get(name)) is not None:
            return app
        if name in self._host.wrong_apps():
            raise UsageError(f"{name} does not run; once it is mended: homebot app load {name}")
        hint = did_you_mean(name, self._apps, f"running are {', '.join(self._apps) or 'none'}")
        raise UsageError(f"no app {name!r} runs; {hint}")

    async def _try(self, planned: PlannedApp) -> str:
        """Start *planned* and wait until it has proved to run; return its crash, empty if there was none."""
        await self._begin(planned)
        return (await self._first_crash([planned.name]))[1]

    async def _begin(self, planned: PlannedApp) -> None:
        """Start *planned*; that it cannot be started counts as a crash."""
        try:
            await self._start(planned)
        except UsageError as exc:
            app = self._apps[planned.name] = _on_end(planned)
            app.crash = str(exc)
            app.has_crashed.set()

    async def _first_crash(self, names: Sequence[str]) -> tuple[str, str]:
        """Wait until all have proved to run; return the first that has not, with its crash, both empty for none."""
        is_code = any(not table_of(self._apps[name].planned.kind) for name in names)
        with anyio.move_on_after(self.trial if is_code else _DATA_TRIAL):
            for name in names:
                await self._apps[name].has_crashed.wait()
        return next(((name, self._apps[name].crash) for name in names if self._apps[name].crash), ("", ""))

    async def _start(self, planned: PlannedApp) -> _RunningApp:
        if self._tasks is None:
            raise UsageError("homebot stops")
        if not planned.kind.__module__.startswith("homebot."):
            watch_created_tasks(self._host.watch_task)
        app = _RunningApp(planned)
        await self._tasks.start(self._hold, app)
        self._apps[planned.name] = app
        return app

    async def _hold(self, app: _RunningApp, *, task_status: TaskStatus[None]) -> None:
        watch: asyncio.TimerHandle | None = None
        try:
            run, title = partial(self._watch, app), f"app {app.planned.name}"
            async with self._supervisor.running(app.planned.name, run, title, retry_after=math.inf):
                try:
                    task_status.started()
                    await app.is_stopped.wait()
                finally:
                    watch = asyncio.get_running_loop().call_later(self.ends_within, self._end_by_force, app)
        finally:
            if watch is not None:
                watch.cancel()
            app.has_ended.set()

    def _end_by_force(self, app: _RunningApp, *, is_last: bool = False) -> None:
        if app.has_ended.is_set():
            return
        if not is_last:  # what waited for the closed code may go on
            asyncio.get_running_loop().call_later(_CLOSED_WITHIN / 2, partial(self._end_by_force, app, is_last=True))
        name = app.planned.name
        running = self._host.running.get(name)
        where = running.end_by_force() if running is not None else ""
        app.problem = f"the app {name} did not end in {self.ends_within:g} s" + (
            f": {where} swallows its cancellation; let CancelledError pass" if where else ""
        )
        _log.error(NOT_ENDED, message=app.problem, app=name)

    async def _watch(self, app: _RunningApp, *, task_status: TaskStatus[None]) -> None:
        try:
            await self._host.serve(app.planned, task_status=task_status)
        except Exception as exc:
            app.crash = error_text(exc)
            app.has_crashed.set()
            raise

    async def _stop(self, app: _RunningApp) -> None:
        app.is_stopped.set()
        with anyio.move_on_after(self.ends_within + _CLOSED_WITHIN):
            await app.has_ended.wait()

    async def _remove(self, name: str) -> None:
        await self._stop(self._apps.pop(name))
        self._supervisor.forget(name)

    def _report(self, event: str, text: str, name: str) -> str:
        _log.info(event, message=text, app=name)
        return text

    def _failure(self, name: str, problem: str) -> UsageError:
        text = f"{name} is not reloaded, the old one runs: {problem}"
        _log.warning(NOT_RELOADED, message=text, app=name)
        return UsageError(text)


async def _answer(change: Callable[[str], Awaitable[str]], request: ChangeAppRequest) -> ChangeAppResponse:
    try:
        return ChangeAppResponse(message=await change(request.app))
    except HomebotError as exc:
        return ChangeAppResponse(success=False, message=str(exc))


def _on_end(planned: PlannedApp) -> _RunningApp:
    app = _RunningApp(planned)
    app.has_ended.set()
    return app


def _info(name: str, app: App | None, crashes: ComponentCrashes | None) -> AppInfo:
    jobs: tuple[AppJob, ...] = ()
    if app is not None:
        given_up = (AppJob(name=run.title, text="", note=run.trouble) for run in islice(app.given_up, _MAX_LISTED))
        waits = (_wait(app.clock.now(), *wait) for wait in islice(app.waits, _MAX_LISTED))
        jobs = (*given_up, *map(_job, app.jobs), *waits)
    if crashes is None:
        return AppInfo(name=name, state="running" if app is not None else "ended", jobs=jobs)
    state = crashes.state if app is None else "running"
    return AppInfo(name=name, state=state, crashes=crashes.count, last_crash=crashes.last, jobs=jobs)


def _wait(now: float, name: str, device: str, seconds: float) -> AppJob:
    return AppJob(name=name, text=f"if {device} stays so", next=Time.from_seconds(now + seconds))


def _job(job: Job) -> AppJob:
    at = job.next
    return AppJob(
        name=job.name,
        text=job.text,
        next=Time.from_seconds(0.0 if at is None else at.timestamp()),
        running_since=Time.from_seconds(job.runs.running_since or 0.0),
        dropped=job.runs.dropped,
        note=job.note,
    )
