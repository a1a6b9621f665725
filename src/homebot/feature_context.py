"""The house, as a running homebot gives it to the server of a feature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping, MutableMapping, Sequence
    from datetime import tzinfo
    from pathlib import Path
    from random import Random

    from anyio.abc import TaskStatus
    from pydantic import BaseModel

    from homebot.apps import App
    from homebot.config import Config, HomeSettings
    from homebot.control import Control
    from homebot.devices.client_rights import CurrentGrants, NodeGrants
    from homebot.discovery import Directory
    from homebot.graph import Graph
    from homebot.recording.lines import RecordingHeader


class FeatureServer(Protocol):
    """The object that ``Feature.server`` returns."""

    def serve(self, name: str) -> None:
        """Create the service or action *name*, which is used for the first time."""


class RunObserver(Protocol):
    """Observes a run from before its apps until after them."""

    async def __call__(self, house: FeatureContext, *, task_status: TaskStatus[None]) -> None:
        """Observe until cancelled; apps start after ``task_status.started()``."""


class AppKeeper(Protocol):
    """The server of a feature that keeps apps beside those of the configuration.

    Attributes:
        problems: Why apps that it keeps do not run, by name.
    """

    problems: dict[str, str]

    def kept_apps(self) -> Iterable[str]:
        """Return the names of the apps to start."""

    def added_to(self, config: Config, app: str) -> Config:
        """Return *config* with the table of *app*, if that is one of these and right; called in a thread."""

    def granted(self, grants: NodeGrants) -> NodeGrants:
        """Return *grants* with those of these apps in line with their tables."""

    async def hints(self, names: Collection[str] = ()) -> Mapping[str, Sequence[str]]:
        """Return the faults of all in the house as it is now, or of those *names* for people, by name."""


class HouseApps(Protocol):
    """The apps of the house.

    Attributes:
        running_apps: Those that run, by name.
        grants: The scopes of their nodes in force.
    """

    running_apps: Mapping[str, App]
    grants: CurrentGrants

    def wrong_apps(self, table: str) -> Mapping[str, str]:
        """Return why apps of an array of tables do not run, by name."""

    async def load(self, *names: str) -> str:
        """Start apps, all or none."""

    async def unload(self, name: str) -> str:
        """Stop an app."""

    async def reload(self, name: str) -> str:
        """Restart an app with its current settings."""


@dataclass(frozen=True, slots=True)
class FeatureContext:
    """The house, for a feature. Parts that may change or start later are functions.

    Attributes:
        graph: The graph, for nodes of its own.
        keeps_data: Whether the run keeps data of its own accord: in files, or in memory of a simulated house.
        is_rehearsal: Whether nothing is sent to devices, as in a dry run and a replay.
        home: The table ``[home]``, such as the language of texts for people, and the place.
        zone: The time zone of the home; None for the computer's.
        file: Returns the path of a data file; None if the run keeps nothing in files.
        apps: The apps of the house, which a feature may start, stop and limit.
        run_facts: Returns the facts of the run that a replay needs, without the time.
        run_app: Runs an app with its settings in a node of that name, until cancelled.
        control: Returns the control layer; None before it runs.
        directory: Returns the directory; None before it runs.
        table: Returns its table of a key as its reader returned it; None if the configuration has none.
        store: Returns the store of a name, which is kept across restarts, and which no app can have.
        config_file: Returns the file of the configuration; None if the run has none. Called in a thread.
        write_stores: Writes all changes of stores now; returns the problem, empty for none.
        notify: Sends people a message with a title from a node of that name; returns whether it was sent.
        random: The source of random numbers.
        began_at: The time before anything started, in seconds since the Unix epoch.
        restart: Ends the run, and begins another; None where only a person can.
    """

    graph: Graph
    keeps_data: bool
    is_rehearsal: bool
    home: HomeSettings
    zone: tzinfo | None
    file: Callable[[str], Path | None]
    apps: HouseApps
    run_facts: Callable[[], Awaitable[RecordingHeader]]
    run_app: Callable[[str, type[App[Any]], BaseModel], Awaitable[None]]
    control: Callable[[], Control | None]
    directory: Callable[[], Directory | None]
    table: Callable[[str], Any]
    store: Callable[[str], MutableMapping[str, Any]]
    config_file: Callable[[], Path | None]
    write_stores: Callable[[], Awaitable[str]]
    notify: Callable[[str, str, str], Awaitable[bool]]
    random: Random
    began_at: float
    restart: Callable[[], None] | None = None
