"""The house, as a running homebot gives it to the server of a feature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping

    from homebot.control import Control
    from homebot.discovery import Directory


class FeatureServer(Protocol):
    """The object that ``Feature.server`` returns."""

    def serve(self, name: str) -> None:
        """Create the service or action *name*, which is used for the first time."""


@dataclass(frozen=True, slots=True)
class FeatureContext:
    """The house, for a feature. Parts that may change or start later are functions.

    Attributes:
        control: Returns the control layer; None before it runs.
        directory: Returns the directory; None before it runs.
        table: Returns its table of a key as its reader returned it; None if the configuration has none.
        store: Returns the store of a name, which is kept across restarts, and which no app can have.
        write_stores: Writes all changes of stores now; returns the problem, empty for none.
    """

    control: Callable[[], Control | None]
    directory: Callable[[], Directory | None]
    table: Callable[[str], Any]
    store: Callable[[str], MutableMapping[str, Any]]
    write_stores: Callable[[], Awaitable[str]]
