"""The house, as a running homebot gives it to the server of a feature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

__all__ = ["FeatureContext"]

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping
    from datetime import tzinfo
    from pathlib import Path

    from pydantic import BaseModel

    from homebot.apps import App
    from homebot.config import HomeSettings
    from homebot.control import Control
    from homebot.discovery import Directory
    from homebot.graph import Graph


class FeatureServer(Protocol):
    """The object that ``Feature.server`` returns."""

    def serve(self, name: str) -> None:
        """Create the service or action *name*, which is used for the first time."""


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
        run_app: Runs an app with its settings in a node of that name, until cancelled.
        control: Returns the control layer; None before it runs.
        directory: Returns the directory; None before it runs.
        table: Returns its table of a key as its reader returned it; None if the configuration has none.
        store: Returns the store of a name, which is kept across restarts, and which no app can have.
        write_stores: Writes all changes of stores now; returns the problem, empty for none.
    """

    graph: Graph
    keeps_data: bool
    is_rehearsal: bool
    home: HomeSettings
    zone: tzinfo | None
    file: Callable[[str], Path | None]
    run_app: Callable[[str, type[App[Any]], BaseModel], Awaitable[None]]
    control: Callable[[], Control | None]
    directory: Callable[[], Directory | None]
    table: Callable[[str], Any]
    store: Callable[[str], MutableMapping[str, Any]]
    write_stores: Callable[[], Awaitable[str]]
