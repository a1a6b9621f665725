"""The base class of apps, each a node that acts on the devices of the house."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import AsyncIterable, Awaitable, Callable, Coroutine, Hashable, Iterable, Iterator, Sequence
from datetime import datetime
from functools import partial
from inspect import isasyncgenfunction, iscoroutinefunction
from itertools import chain
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeAlias, TypeVarTuple, get_args, get_origin, overload
from weakref import WeakSet

import anyio
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel, ConfigDict
from typing_extensions import TypeVar

from homebot.apps.context import AppContext
from homebot.apps.created_tasks import CreatedTasks
from homebot.apps.reactions import ItemHandler, Reaction
from homebot.apps.run_modes import HandlerRuns, RunHandler, RunMode, check_handler
from homebot.config import Urgency
from homebot.devices import Devices
from homebot.devices.batch import at_once
from homebot.devices.handles.handle import Handle
from homebot.errors import RefusedError, UsageError
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.support.isolation import frames_of, isolated
from homebot.support.production_loop import is_ours_or_the_users, place_of_frame

if TYPE_CHECKING:
    from homebot.apps.jobs import Job
    from homebot.apps.schedule import Length, Schedule
    from homebot.apps.store import Store
    from homebot.devices.history_client import HistoryClient
    from homebot.devices.history_messages import EnergyOfDay, HistorySeries
    from homebot.devices.outcomes import Outcome
    from homebot.devices.scene_client import Scenes


class AppSettings(BaseModel):
    """The base class of app tables: read once; an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class NoSettings(AppSettings):
    """The empty table of an app without settings."""


SettingsT_co = TypeVar("SettingsT_co", bound=BaseModel, default=BaseModel, covariant=True)
ItemT = TypeVar("ItemT")
Args = TypeVarTuple("Args")
HandleT = TypeVar("HandleT", bound=Handle)
_Queries: TypeAlias = AsyncIterable[ItemT] | Sequence[AsyncIterable[ItemT]]


class App(ABC, Generic[SettingsT_co]):
    """The base class of apps; the entry-point group is ``homebot.apps``.

    Override :meth:`run`. An app with settings names their model: ``class Hall(App[HallSettings])``.

    Args:
        node: The node of the app, ``/<name>``.
        settings: The table ``[apps.NAME]`` of the configuration, validated.

    Attributes:
        Settings: The model of the app's table; the default accepts no keys.
        node: The node of the app, for its topics, services, timers and parameters.
        settings: The settings.
        clock: The clock to use in place of the computer's: ``clock.now()`` is in seconds since the Unix epoch.
        context: Facts about the home; the runtime sets it before :meth:`run`.
    """

    Settings: ClassVar[type[BaseModel]] = NoSettings

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if not iscoroutinefunction(run := cls.run):
            word = "yields" if isasyncgenfunction(run) else "is a plain function"
            raise UsageError(f"{cls.__name__}.run {word}; write `async def run(self)`, which may await")
        for base in getattr(cls, "__orig_bases__", ()):
            if isinstance(origin := get_origin(base), type) and issubclass(origin, App):
                given = get_args(base)[0]
                cls.Settings = given if isinstance(given, type) else cls.Settings

    def __init__(self, node: Node, settings: SettingsT_co) -> None:
        self.node = node
        self.settings = settings
        self.log = node.log
        self.clock = node.graph.clock
        self.devices = Devices(node)
        self.context = AppContext()
        self._store: Store | None = None
        self._schedule: Schedule | None = None
        self._reactions: WeakSet[Reaction[Any]] = WeakSet()
        self._tasks: TaskGroup | None = None
        self._log_limit = LogLimit(self.clock)
        self.created_tasks = CreatedTasks(node.full_name)
        self._work: set[Coroutine[object, object, object]] = set()
        self._is_forced = False

    @property
    def store(self) -> Store:
        """Values that the app keeps across restarts: ``self.store["armed"] = True``."""
        if self._store is None:
            self._store = self.context.store_of(self.node.name)
        return self._store

    @abstractmethod
    async def run(self) -> None:
        """Run until cancelled; the app has ended normally when this has returned and its tasks have ended.

        An exception is logged and the app is restarted, at first after half a second; after five crashes within a
        minute it is given up.
        """

    def now(self) -> datetime:
        """Return the date and time in the home's zone."""
        return datetime.fromtimestamp(self.clock.now(), self.context.zone)

    @property
    def jobs(self) -> tuple[Job, ...]:
        """The pending jobs of :meth:`after`, :meth:`every`, :meth:`daily` and :meth:`at`."""
        return () if self._schedule is None else self._schedule.jobs

    @property
    def waits(self) -> Iterator[tuple[str, str, float]]:
        """The handlers that will be called if a device stays as it is, with its name and the remaining seconds."""
        for reaction in self._reactions:
            yield from ((reaction.name, device, seconds) for device, seconds in reaction.waiting)

    @property
    def given_up(self) -> Iterator[HandlerRuns]:
        """The runs of :meth:`on` that are not called any more because they failed too often."""
        return chain.from_iterable(reaction.given_up for reaction in self._reactions)

    @overload
    def after(
        self,
        delay: Length,
        handler: RunHandler,
        *,
        name: str | None = None,
        durable: bool = False,
        catch_up: Length = "0s",
    ) -> Job: ...

    @overload
    def after(
        self,
        delay: Length,
        handler: Callable[[*Args], Awaitable[object] | None],
        *,
        args: tuple[*Args],
        name: str | None = None,
        durable: bool = False,
        catch_up: Length = "0s",
    ) -> Job: ...

    def after(
        self,
        delay: Length,
        handler: Callable[..., Awaitable[object] | None],
        *,
        args: tuple[object, ...] = (),
        name: str | None = None,
        durable: bool = False,
        catch_up: Length = "0s",
    ) -> Job:
        """Call *handler* once, *delay* from now: ``"2m"``, seconds or a timedelta.

        Args:
            args: The arguments of *handler*; JSON values if the job is durable.
            name: The name of the job; it replaces a pending job of this name.
            durable: Whether it survives a restart, for which it needs a *name*, and a method of the app.
            catch_up: How late a durable job may be because homebot was stopped; later ones are dropped and logged.
        """
        return self._jobs().after(delay, handler, args, name, durable=durable, catch_up=catch_up)

    def every(
        self,
        period: Length,
        handler: RunHandler,
        *,
        name: str | None = None,
        offset: Length = "0s",
        mode: RunMode = "single",
    ) -> Job:
        """Call *handler* every *period*, first after one period plus *offset*."""
        return self._jobs().every(period, handler, name, offset, mode)

    def daily(
        self,
        time: str,
        handler: RunHandler,
        *,
        days: str = "",
        name: str | None = None,
        catch_up: Length = "0s",
        mode: RunMode = "single",
    ) -> Job:
        """Call *handler* each day at *time*, such as ``"22:00"``, in the home's zone.

        Args:
            days: Days of the week, such as ``"mon-fri"`` or ``"sat,sun"``; all by default.
            catch_up: How late a call may be because homebot was stopped or the computer slept; later ones are skipped.
        """
        return self._jobs().daily(time, handler, days, name, catch_up, mode)

    def at(
        self,
        event: str,
        handler: RunHandler,
        *,
        offset: Length = "0s",
        jitter: Length = "0s",
        name: str | None = None,
        catch_up: Length = "0s",
        mode: RunMode = "single",
    ) -> Job:
        """Call *handler* each day at ``"sunset"``, ``"sunrise"``, ``"dawn"``, ``"dusk"`` or ``"noon"``.

        Args:
            offset: Time relative to the event, such as ``"-30m"``.
            jitter: The most by which each call is randomly earlier or later.
            catch_up: As for :meth:`daily`.
        """
        return self._jobs().at(event, handler, offset, jitter, name, catch_up, mode)

    def sun_is_up(self) -> bool:
        """Return whether the sun is above the horizon of the home.

        Raises:
            UsageError: The location of the home is unknown.
        """
        from homebot.apps.sun import is_sun_up  # noqa: PLC0415 - astral is for apps that ask

        return is_sun_up(self.clock.now(), self.context.latitude, self.context.longitude)

    def _jobs(self) -> Schedule:
        if self._schedule is None:
            from homebot.apps.schedule import Schedule  # noqa: PLC0415 - few apps have one

            self._schedule = Schedule(self)
        return self._schedule

    @property
    def scenes(self) -> Scenes:
        """The scenes of the house: ``await self.scenes.apply("Film")``."""
        from homebot.devices.scene_client import Scenes  # noqa: PLC0415 - few apps use them

        return Scenes(self.node)

    async def notify(self, message: str, *, title: str = "", urgency: Urgency = "normal") -> bool:
        """Send *message* to people as configured in the table ``[notify]``; without it, only log the message.

        Args:
            urgency: ``high`` has the highest priority of services that have one, ``low`` the lowest.

        Returns:
            Whether it was sent; a failure is logged.
        """
        return await self.context.notify(message, title, self.node.name, urgency)

    async def history(
        self, handle: Handle, capability: str, since: str | float = "24h", points: int = 0
    ) -> HistorySeries:
        """Return the history of *capability*, for example ``power``, with ``times`` and ``values``.

        Args:
            since: How far back, such as ``"7d"``, or seconds.
            points: The largest number of values, 500 by default; if there are more, ``values`` are means.

        Raises:
            UsageError: No history is kept, or an argument is wrong.
        """
        return await self._history.read(handle, capability, since, points)

    async def energy(self, query: str = "", since: str | float = "6d") -> tuple[EnergyOfDay, ...]:
        """Return the energy by day and device, for the devices that fit *query*.

        Raises:
            UsageError: No history is kept, or *query* is not a query.
        """
        return await self._history.read_energy(query, since)

    @property
    def _history(self) -> HistoryClient:
        from homebot.devices.history_client import HistoryClient  # noqa: PLC0415 - few apps look back

        return HistoryClient(self.node)

    @overload
    def on(
        self,
        query: _Queries[ItemT],
        handler: ItemHandler[ItemT],
        *,
        mode: RunMode = ...,
        most: int = ...,
        key: Callable[[ItemT], Hashable] | None = ...,
    ) -> Reaction[ItemT]: ...

    @overload
    def on(
        self,
        query: _Queries[ItemT],
        *,
        mode: RunMode = ...,
        most: int = ...,
        key: Callable[[ItemT], Hashable] | None = ...,
    ) -> Callable[[ItemHandler[ItemT]], Reaction[ItemT]]: ...

    def on(
        self,
        query: _Queries[ItemT],
        handler: ItemHandler[ItemT] | None = None,
        *,
        mode: RunMode = "single",
        most: int = 10,
        key: Callable[[ItemT], Hashable] | None = None,
    ) -> Reaction[ItemT] | Callable[[ItemHandler[ItemT]], Reaction[ItemT]]:
        """Call *handler* with each item of one or several live queries; without *handler*, return a decorator.

        The item is the cause of the commands that the handler gives: a button press counts as a person's request.

        Args:
            query: For example ``self.devices.follow(Light)``.
            handler: A function or coroutine function of one item; a failure costs only that call, the fifth in a row
                all further ones.
            mode: The rule for a call while an earlier one runs: ``single`` drops it, ``restart`` cancels the earlier
                one, ``queued`` waits for its turn, ``parallel`` runs concurrently.
            most: The limit of running and waiting calls, at which ``queued`` and ``parallel`` drop the next.
            key: Returns the key of an item; calls with different keys are independent, as for
                :func:`homebot.apps.rooms.per_room`.

        Returns:
            The reaction; its ``cancel()`` ends it.

        Raises:
            UsageError: The app does not run, there is no query, or an argument is wrong.
        """
        if handler is None:
            return partial(self.on, query, mode=mode, most=most, key=key)
        queries = query if isinstance(query, Sequence) else (query,)
        reaction = Reaction(self.node, self.start_task, queries, handler, mode, most, key)
        self._reactions.add(reaction)
        return reaction

    def log_limited(self, event: str, text: str, **facts: object) -> None:
        """Log *text* at level info with its *facts*, the same text at most once in 10 s."""
        if self._log_limit.allows(f"{event} {text}") is not None:
            self.log.info(event, message=text, **facts)

    async def each(
        self, command: Callable[[HandleT], Coroutine[object, object, Outcome]], handles: Iterable[HandleT]
    ) -> list[Outcome]:
        """Give a command to all *handles* concurrently: ``await self.each(Light.turn_off, lamps)``.

        One message is sent if the handles are exactly the members of a group that takes the command.

        Returns:
            The outcomes, in the order of the handles; ``Refused`` for a command that makes no sense to its device.

        Raises:
            UsageError: *command* is not a function of a handle.
        """
        from homebot.devices.outcomes import Refused  # noqa: PLC0415 - with the first command

        check_handler(command, "a handle")
        outcomes: dict[int, Outcome] = {}

        async def command_one(number: int, handle: HandleT) -> None:
            try:
                outcomes[number] = await command(handle)
            except RefusedError as exc:
                outcomes[number] = Refused("device", exc.reason)

        async with anyio.create_task_group() as tasks:
            with at_once():
                for number, handle in enumerate(handles):
                    tasks.start_soon(command_one, number, handle)
        return [outcomes[number] for number in sorted(outcomes)]

    def start_task(self, function: Callable[[], Coroutine[object, object, object]]) -> None:
        """Call *function* in a task of the app, which is cancelled with the app and whose exception ends it.

        Raises:
            UsageError: The app does not run, or *function* is not a coroutine function.
        """
        if not callable(function):
            raise UsageError(f"start_task() takes a coroutine function without parentheses, not {function!r:.60}")
        if self._tasks is None:
            raise UsageError(f"{self.node.full_name} does not run yet; start its tasks in run()")
        self._tasks.start_soon(self._isolate, function)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the app; the runtime calls this."""
        async with self.created_tasks.watched(), anyio.create_task_group() as self._tasks:
            task_status.started()
            if self.context.keeps_values() and "_timers" in self.store:
                self._jobs().resume()
            await self._isolate(self.run)

    async def _isolate(self, function: Callable[[], Coroutine[object, object, object]]) -> None:
        """Await *function* in isolation; its group would mistake a stray cancellation for its own."""
        with isolated(self.node.full_name):
            work = function()
            self._work.add(work)
            try:
                await work
            except (RuntimeError, ExceptionGroup):
                if self._is_forced:  # closed, or its tasks are, so that it cannot go on
                    await anyio.lowlevel.checkpoint()
                raise
            finally:
                self._work.discard(work)

    def end_by_force(self) -> str:
        """Close the code that goes on although the app is cancelled; return its places."""
        self._is_forced = True
        waiting = [(work, frames_of(work)) for work in (*self.created_tasks.work(), *self._work)]
        # a group of tasks ends with its tasks, and must not be closed before
        alone = [(work, frames) for work, frames in waiting if not frames or frames[-1].f_code.co_name != "__aexit__"]
        places: list[str] = []
        for work, frames in alone or waiting:
            places += map(place_of_frame, (list(filter(is_ours_or_the_users, frames)) or frames)[-1:])
            try:
                work.close()
            except Exception as exc:  # noqa: BLE001 - code that also refuses this, or fails at its end
                self.log.error("app.not_closed", message=f"it did not let itself be closed: {exc}")
        self.created_tasks.end_closed()
        return " and ".join(dict.fromkeys(places))
