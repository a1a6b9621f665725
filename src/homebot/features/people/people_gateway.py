"""The gateway with the people of ``[people]`` and of other systems, and their household, as devices."""

import errno
import socket
from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress
from typing import ClassVar, Final, TypeAlias, final

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.devices.gateway_messages import Command
from homebot.devices.house_view import HouseView
from homebot.errors import RefusedError
from homebot.features.people.settings import PeopleSettings, PersonSettings
from homebot.features.people.tracker_watch import TrackerWatch
from homebot.features.people.whereabouts import Sign, where_is
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.support.names import did_you_mean

Ping: TypeAlias = Callable[[str], Awaitable[bool | None]]
"""Returns whether an address answers; None if there is no network to ask in."""

_WITHIN: Final = 2.0
"""Seconds; a sleeping phone wakes every few hundred milliseconds."""

_PORT: Final = 62078
"""Open on iPhones; any other phone refuses it at once, which is an answer too."""

_NO_NETWORK: Final = frozenset({errno.ENETUNREACH, errno.ENETDOWN})
_REFUSED: Final = frozenset({errno.ECONNREFUSED, errno.ECONNRESET})


async def answers(address: str) -> bool | None:
    """Ask by a connection; see :data:`Ping`."""
    try:
        with anyio.fail_after(_WITHIN):
            stream = await anyio.connect_tcp(address, _PORT)
    except TimeoutError:
        return False
    except socket.gaierror:
        return None
    except OSError as exc:
        errnos = {error.errno for error in _errors(exc)}
        return True if errnos & _REFUSED else None if errnos & _NO_NETWORK else False
    with suppress(OSError):
        await stream.aclose()
    return True


def _errors(exc: BaseException) -> list[OSError]:
    """Return the errors of all addresses of a name, which anyio gathers in the cause."""
    inner = exc.__cause__
    group = inner.exceptions if isinstance(inner, BaseExceptionGroup) else (inner,)
    return [error for error in (exc, *group) if isinstance(error, OSError)]


AT_HOME: Final = "at_home"
ALL_AT_HOME: Final = "all_at_home"
HOUSEHOLD: Final = "household"

_ASKED_EVERY: Final = 30.0
_HEARD: Final = 100.0
"""Seconds for which an answer of a phone counts: three that were asked for got lost."""

_SEEN_EVERY: Final = 900.0
"""Seconds after which the people are published again, so that they do not become stale."""

_SETTLES: Final = 1.0
"""Seconds in which news are gathered: a phone that was offline tells all at once, a system its persons one by one."""


@final
class PeopleGateway(Gateway):
    """Tells of each person, and of the household, whether they are at home; see :mod:`.whereabouts`.

    Args:
        ping: Asks a phone whether it is there.
    """

    Settings: ClassVar[type[BaseModel]] = PeopleSettings

    def __init__(
        self, node: Node, settings: PeopleSettings, context: GatewayContext | None = None, ping: Ping = answers
    ) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self._people: dict[str, tuple[str, PersonSettings]] = {}
        self._ping = ping
        self._heard_at: dict[str, float] = {}
        self._has_answer = False
        self._since: dict[str, tuple[Sign, float]] = {}
        self._told: dict[str, dict[str, bool | None]] = {}
        self._trackers = TrackerWatch()
        self._view: HouseView | None = None
        self._devices = PublishedDevices(self, self._refuse, settings, find_problems=self._missing)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the trackers, and ask the phones, until cancelled."""
        self._publish_devices()
        self.publish_state("active")
        task_status.started()
        view = self._view = HouseView.of(self.node)
        view.add(self._trackers)
        async with anyio.create_task_group() as tasks:
            for key, (_, person) in self._people.items():
                if person.ping:
                    tasks.start_soon(self._ask, key, person.ping)
            while True:
                self._trackers.changed = anyio.Event()
                self._publish_devices()
                with anyio.move_on_after(await self._look(view, self.node.graph.clock.monotonic())):
                    await self._trackers.changed.wait()
                    await anyio.sleep(0 if self._has_answer else _SETTLES)
                self._has_answer = False

    def _publish_devices(self) -> None:
        """Publish the people of the settings and of other systems, and their household."""
        people = {f"person/{fold(name)}": (name, person) for name, person in self._settings.people.items()}
        for device_id, name in self._trackers.persons(self._settings.people).items():
            people[f"person#{device_id}"] = name, PersonSettings.model_construct(trackers=(device_id,))
        for key in self._told.keys() - people.keys() - ({HOUSEHOLD} if people else set()):
            self._devices.remove(key, "no system names the person any more")
            del self._told[key]
        self._people = people
        for key, (name, _) in people.items():
            person = GatewayDevice(key, name, (simple_part("x_person", readable=(AT_HOME,)),))
            self._devices.put(person, "the person is known")
        if people:
            household = simple_part("x_household", readable=(AT_HOME, ALL_AT_HOME))
            self._devices.put(GatewayDevice(HOUSEHOLD, "Household", (household,)), "all who are known")

    async def _look(self, view: HouseView, now: float) -> float:
        """Report the changes; return the seconds until silence may change something."""
        lags = await self._trackers.catch_up(view)
        due = [
            now + (_ASKED_EVERY if lags else _SEEN_EVERY),
            *(at + _HEARD for at in self._heard_at.values() if at + _HEARD > now),
        ]
        at_home: list[bool | None] = []
        for key, (_, person) in self._people.items():
            where = where_is([*self._signs(view, key, person, now)], now, person.away_after)
            due.append(where.due)
            at_home.append(where.is_home)
            await self._report(key, {AT_HOME: where.is_home})
        is_any = True if True in at_home else None if None in at_home else False
        are_all = False if False in at_home else None if None in at_home else True
        if at_home:
            await self._report(HOUSEHOLD, {AT_HOME: is_any, ALL_AT_HOME: are_all})
        return min(due) - now

    async def _report(self, key: str, values: dict[str, bool | None]) -> None:
        if self._told.get(key) != values:
            self._told[key] = values
            await self._devices.report(key, values)

    def _signs(self, view: HouseView, key: str, person: PersonSettings, now: float) -> Iterator[tuple[Sign, float]]:
        for text in person.trackers:
            for place, reported in self._trackers.signs(view, text).items():
                yield self._add_time(f"{key} {place}", reported, now)
        if person.ping:
            heard_at = self._heard_at.get(key)
            is_home = heard_at is not None and now - heard_at < _HEARD
            sign: Sign = "home" if is_home else "unknown" if heard_at is None else "silent"
            yield self._add_time(key, sign, now)

    def _add_time(self, source: str, sign: Sign, now: float) -> tuple[Sign, float]:
        """Return *sign* with the time since which it has been so, by the monotonic clock: the other one may be set."""
        if (known := self._since.get(source)) is None or known[0] != sign:
            self._since[source] = (sign, now)
        return self._since[source]

    async def _ask(self, key: str, address: str) -> None:
        """Ask a phone again and again; its silence means nothing while homebot itself has no network."""
        while True:
            is_there = await self._ping(address)
            if is_there:
                self._heard_at[key] = self.node.graph.clock.monotonic()
            elif is_there is None:
                self._heard_at.pop(key, None)
            self._has_answer = True
            self._trackers.changed.set()
            await anyio.sleep(_ASKED_EVERY)

    def _missing(self) -> Iterator[str]:
        """Yield the problem of each tracker that no device is."""
        if (view := self._view) is None:
            return
        for name, person in self._settings.people.items():
            for text in person.trackers:
                if not self._trackers.signs(view, text):
                    hint = did_you_mean(text, self._trackers.names, "`homebot find trackers` shows them")
                    yield f"people.{name}: no device with a place is called {text!r}; {hint}"

    async def _refuse(self, command: Command) -> None:
        raise RefusedError(command.capability, "no command sends people home")
