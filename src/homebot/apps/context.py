"""The facts about the home that apps can use."""

from __future__ import annotations

import math
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from datetime import tzinfo
from typing import Protocol

from homebot.apps.store import Store
from homebot.clock import read_zone
from homebot.config import Urgency


async def _write_nowhere() -> None:
    """Keep values in memory."""


class SendNotification(Protocol):
    """Sends people a message, with its title, the name of the app and, for an alert, its kind."""

    async def __call__(self, message: str, title: str, app: str, urgency: Urgency = "normal", kind: str = "") -> bool:
        """Return whether it was sent."""
        ...


async def _send_nowhere(message: str, title: str, app: str, urgency: Urgency = "normal", kind: str = "") -> bool:  # noqa: ARG001 - a port's signature
    return False


@dataclass(frozen=True, slots=True)
class AppContext:
    """Facts about the home of an app.

    Attributes:
        zone_name: The IANA name of the home's time zone; empty for the computer's.
        latitude: Degrees north of the equator; None if not configured.
        longitude: Degrees east of Greenwich; None if not configured.
        store_of: Returns the store of an app by its name; in memory by default.
        keeps_values: Returns whether an app may have values from an earlier run.
        notify: Sends people a message, with its title and the name of the app; returns whether it was sent.
        notifies: Returns whether there is a way to send messages; else they are only logged.
        not_sent_because: Returns why a part of the last message was not sent; empty if all of it was.
        rehearse: Called with an app and an act of a robot that is only recorded, in a replay or dry run; None else.
        write_stores: Writes the stores of all apps at once, instead of within five seconds.
        began_at: When homebot started, in seconds since the Unix epoch.
        asleep: Returns the seconds for which the computer was suspended, while the monotonic clock stood still.
    """

    zone_name: str = "UTC"
    latitude: float | None = None
    longitude: float | None = None
    store_of: Callable[[str], Store] = Store
    keeps_values: Callable[[], bool] = lambda: False
    notify: SendNotification = _send_nowhere
    notifies: Callable[[], bool] = lambda: False
    not_sent_because: Callable[[], str] = str
    rehearse: Callable[[str, str], None] | None = None
    write_stores: Callable[[], Coroutine[object, object, object]] = _write_nowhere
    asleep: Callable[[], float] = float
    began_at: float = -math.inf

    @property
    def zone(self) -> tzinfo:
        """The home's time zone."""
        return read_zone(self.zone_name)
