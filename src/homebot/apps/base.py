"""The base class of apps: a node that acts on the devices of the house."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from datetime import datetime, tzinfo
from typing import TYPE_CHECKING, ClassVar, Generic, get_args, get_origin

import anyio
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel, ConfigDict
from typing_extensions import TypeVar

from homebot.clock import read_zone
from homebot.devices import Devices
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.support.isolation import isolated

if TYPE_CHECKING:
    from homebot.apps.store import Store

__all__ = ["App", "AppContext", "AppSettings", "NoSettings"]


def _store_in_memory(app: str) -> Store:
    from homebot.apps.store import Store  # noqa: PLC0415 - few apps keep anything

    return Store(app)


@dataclass(frozen=True, slots=True)
class AppContext:
    """Facts about the home of an app.

    Attributes:
        zone_name: The IANA name of the home's time zone; empty for the computer's.
        latitude: Degrees north of the equator; None where the configuration does not say, like the next.
        longitude: Degrees east of Greenwich.
        store_of: Returns the store of an app by its name; by default one in memory.
    """

    zone_name: str = "UTC"
    latitude: float | None = None
    longitude: float | None = None
    store_of: Callable[[str], Store] = _store_in_memory

    @property
    def zone(self) -> tzinfo:
        """The home's time zone."""
        return read_zone(self.zone_name)


class AppSettings(BaseModel):
    """The base class of tables of apps: read once, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class NoSettings(AppSettings):
    """The empty table of an app without settings."""


SettingsT = TypeVar("SettingsT", bound=BaseModel, default=BaseModel)


class App(ABC, Generic[SettingsT]):
    """The base class of apps; the entry-point group is ``homebot.apps``.

    Override :meth:`run`. An app with settings names their model: ``class Hall(App[HallSettings])``.

    Args:
        node: The node of the app, ``/<name>``.
        settings: The table ``[apps.NAME]`` of the configuration, validated.

    Attributes:
        Settings: The model of the app's table; by default a table with keys is an error.
        node: The node of the app, for its topics, services, timers and parameters.
        settings: The settings.
        log: The log of the node.
        clock: The clock, which stands for the computer's: ``clock.now()`` in seconds since the Unix epoch.
        devices: The devices of the house.
        context: Facts about the home; the runtime sets it before :meth:`run`.
    """

    Settings: ClassVar[type[BaseModel]] = NoSettings

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        for base in getattr(cls, "__orig_bases__", ()):
            if isinstance(origin := get_origin(base), type) and issubclass(origin, App):
                given = get_args(base)[0]
                cls.Settings = given if isinstance(given, type) else cls.Settings

    def __init__(self, node: Node, settings: SettingsT) -> None:
        self.node = node
        self.settings = settings
        self.log = node.log
        self.clock = node.graph.clock
        self.devices = Devices(node)
        self.context = AppContext()
        self._store: Store | None = None
        self._tasks: TaskGroup | None = None

    @property
    def store(self) -> Store:
        """Values that the app keeps over a restart: ``self.store["armed"] = True``."""
        if self._store is None:
            self._store = self.context.store_of(self.node.name)
        return self._store

    @abstractmethod
    async def run(self) -> None:
        """Run until cancelled; the app ends in good order when this has returned and its tasks have ended.

        An exception is logged and the app started again, half a second later at first; after five crashes within a
        minute it is given up.
        """

    def now(self) -> datetime:
        """Return the date and time in the home's zone."""
        return datetime.fromtimestamp(self.clock.now(), self.context.zone)

    def start_task(self, function: Callable[[], Coroutine[object, object, object]]) -> None:
        """Call *function* in a task of the app, which is cancelled with it; its exception is the app's.

        Raises:
            UsageError: The app does not run.
        """
        if self._tasks is None:
            raise UsageError(f"{self.node.full_name} does not run yet; start its tasks in run()")
        self._tasks.start_soon(self._isolated, function)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Run the app; the runtime calls this."""
        async with anyio.create_task_group() as self._tasks:
            task_status.started()
            await self._isolated(self.run)

    async def _isolated(self, function: Callable[[], Coroutine[object, object, object]]) -> None:
        """Await *function*; else its group would take a stray cancellation for its own."""
        with isolated(self.node.full_name):
            await function()
