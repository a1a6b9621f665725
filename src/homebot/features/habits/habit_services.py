"""Services that propose routines of the habits of the people in the house. Loaded with the first question.

The history and the journal are read and searched in a thread, in slices, so that a search can be cancelled. Nothing is
kept but rejections, and nothing leaves the machine.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, MutableMapping, Sequence
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final, TypeVar, final

import anyio
from anyio import to_thread

from homebot.clock import read_zone, zone_name
from homebot.devices import Device, names
from homebot.devices.app_messages import (
    ChangeRoutine,
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    ListRoutines,
    RoutineInfo,
    RoutinesRequest,
)
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.history_messages import MAX_POINTS, HistorySeries, ReadHistory, ReadHistoryRequest
from homebot.devices.journal_messages import MAX_ENTRIES, JournalEntry, ReadJournal, ReadJournalRequest
from homebot.errors import HomebotError, PeerError
from homebot.features.habits import SUGGEST_HABITS
from homebot.features.habits.days import DAY
from homebot.features.habits.habit import FoundHabit, TriedHabit
from homebot.features.habits.messages import (
    DecideHabit,
    DecideHabitRequest,
    HabitProposal,
    SuggestHabits,
    SuggestHabitsRequest,
    SuggestHabitsResponse,
)
from homebot.features.habits.proposal import UNDONE, is_same, name_of, proposal_of, undone_commands
from homebot.features.habits.recorded import MAX_HAPPENINGS, Home, recorded_days
from homebot.features.habits.trial import try_habits
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time
from homebot.support.folding import fold
from homebot.words.device_words import DeviceWords

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from homebot.config import HomeSettings
    from homebot.feature_context import FeatureContext

T = TypeVar("T")

_DAYS: Final = 28
_NO_HISTORY: Final = "no history is kept, or it has not begun yet; write `enabled = true` in [history] of homebot.toml"
_NO_ROUTINES: Final = "there are no routines in this homebot"
_REJECTED: Final = "habits/rejected"
"""The store of the habits that nobody wants as routines, by the ids of their proposals."""

_FRESH: Final = 600.0
"""Seconds for which an answer is given again without a search."""

_MAX_PAGES: Final = 100
"""Pages of the journal, of a thousand entries each; older ones are left out."""

_MAX_REJECTED: Final = 300
_SLICE: Final = 0.05
"""Seconds of a search until it may be cancelled."""

_ENTRIES: Final = frozenset({"changed", "judged", "requested"})


@final
class HabitServices:
    """Proposes routines, and keeps rejections in *rejected*."""

    def __init__(
        self,
        node: Node,
        home: HomeSettings,
        rejected: MutableMapping[str, Any],
        write_stores: Callable[[], Awaitable[object]],
    ) -> None:
        self._node = node
        self._home = home
        self._rejected = rejected
        self._write_stores = write_stores
        self._routines = node.create_client(ListRoutines, names.LIST_ROUTINES)
        self._change = node.create_client(ChangeRoutine, names.CHANGE_ROUTINE)
        self._lookup = DeviceLookup(node)
        self._history = node.create_client(ReadHistory, names.READ_HISTORY)
        self._journal = node.create_client(ReadJournal, names.READ_JOURNAL)
        self._turn = anyio.Lock()
        self._last: tuple[float, int, SuggestHabitsResponse] | None = None

    def serve(self, name: str) -> None:
        """Create the service with this name."""
        if name == SUGGEST_HABITS.name:
            self._node.create_service(SuggestHabits, name, self._suggest, concurrent=True)
        else:
            self._node.create_service(DecideHabit, name, self._decide)

    async def _suggest(self, request: SuggestHabitsRequest) -> SuggestHabitsResponse:
        days, now = request.days or _DAYS, self._node.graph.clock.now()
        async with self._turn:
            if self._last is None or self._last[1] != days or not 0 <= now - self._last[0] < _FRESH:
                try:
                    self._last = now, days, await self._searched(now - days * DAY, now)
                except HomebotError as exc:
                    return SuggestHabitsResponse(success=False, message=str(exc))
        answer = self._last[2]
        running = await self._running_routines()
        left = tuple(proposal for proposal in answer.proposals if self._is_open(proposal, running))
        return answer.model_copy(update={"proposals": left})

    async def _decide(self, request: DecideHabitRequest) -> ChangeRoutineResponse:
        known = () if self._last is None else self._last[2].proposals
        running = await self._running_routines()
        proposal = next(
            (proposal for proposal in known if proposal.id == request.id and self._is_open(proposal, running)), None
        )
        if proposal is None:
            message = f"there is no proposal {request.id!r} now; `homebot suggest` lists them"
            return ChangeRoutineResponse(success=False, message=message)
        if request.accept:
            if not self._change.service_is_ready():
                return ChangeRoutineResponse(success=False, message=_NO_ROUTINES)
            change = ChangeRoutineRequest(change="new", text=proposal.text, of_habit=True, issuer=request.issuer)
            if proposal.removes:  # people undo that routine
                change = ChangeRoutineRequest(name=proposal.removes, change="remove", issuer=request.issuer)
            return await self._change.call(change)
        for oldest in list(self._rejected)[: max(0, len(self._rejected) + 1 - _MAX_REJECTED)]:
            del self._rejected[oldest]
        self._rejected[proposal.id] = {"when": proposal.when, "do": proposal.do}
        await self._write_stores()
        return ChangeRoutineResponse(message=f"rejected {proposal.name}; it is not proposed again")

    async def _running_routines(self) -> Sequence[RoutineInfo]:
        if not self._routines.service_is_ready():
            return ()
        return [routine for routine in (await self._routines.call(RoutinesRequest())).routines if not routine.problem]

    def _is_open(self, proposal: HabitProposal, running: Sequence[RoutineInfo]) -> bool:
        """Return whether nobody rejected *proposal*, and none of the *running* routines does the same already."""
        if proposal.removes:
            return proposal.id not in self._rejected and proposal.removes in {routine.name for routine in running}
        wanted = fold(proposal.do)
        if any(is_same(proposal, str(rejected["when"]), str(rejected["do"])) for rejected in self._rejected.values()):
            return False
        return not any(
            wanted in map(fold, info.steps) and any(is_same(proposal, when, proposal.do) for when in info.when)
            for info in running
        )

    async def _searched(self, since: float, until: float) -> SuggestHabitsResponse:
        if not self._history.service_is_ready():
            raise PeerError(_NO_HISTORY)
        devices = await self._lookup.devices()
        entries = await self._entries(since)
        series = [history for device in devices for history in await self._series(device, since, until)]
        zone = await to_thread.run_sync(read_zone, self._home.zone)
        home = Home(zone, self._home.latitude, self._home.longitude)
        made = {routine.app: routine.name for routine in await self._running_routines() if routine.of_habit}
        search = _search(devices, series, entries, home, made)
        while (answer := await to_thread.run_sync(_slice, search)) is None:
            pass
        return answer.model_copy(update={"zone": zone_name(self._home.zone)})

    async def _series(self, device: Device, since: float, until: float) -> list[HistorySeries]:
        """Return the states and events of the main parts of *device*; numbers start no routine."""
        series: list[HistorySeries] = []
        named = {can.name for part in device.parts if not part.part.category for can in part.part.capabilities}
        for name in sorted(named):
            if CAPABILITIES.get(name, OWN).kind not in {"bool", "text"}:
                continue
            request = ReadHistoryRequest(
                device=device.id,
                capability=name,
                since=Time.from_seconds(since),
                until=Time.from_seconds(until),
                points=MAX_POINTS,
            )
            answer = await self._history.call(request)
            if not answer.success:
                raise PeerError(answer.message)
            series += [history for history in answer.series if history.words]
        return series

    async def _entries(self, since: float) -> list[JournalEntry]:
        """Return the entries about persons and commands, oldest first: the newest hundred thousand."""
        pages: list[list[JournalEntry]] = []
        until = Time(sec=0, nanosec=0)
        for _ in range(_MAX_PAGES):
            request = ReadJournalRequest(since=Time.from_seconds(since), until=until, limit=MAX_ENTRIES)
            page = await self._journal.call(request)
            if not page.success:
                raise PeerError(page.message)
            if pages:  # this page has those at its newest time as well
                pages[-1] = [entry for entry in pages[-1] if entry.at != until]
            pages.append([entry for entry in page.entries if entry.kind in _ENTRIES])
            if page.complete or not page.entries or page.entries[0].at == until:
                break
            until = page.entries[0].at
        return [entry for page in reversed(pages) for entry in page]


def _search(
    devices: Sequence[Device],
    series: list[HistorySeries],
    entries: list[JournalEntry],
    home: Home,
    made: Mapping[str, str],
) -> Generator[SuggestHabitsResponse | None]:
    """Yield None after each slice of work, and at the end, with *series* and *entries* emptied, the answer.

    Args:
        made: The names of the routines that were made of habits, by app.
    """
    words = DeviceWords(devices)
    yield None
    days = recorded_days(words, series, entries, home)
    best: dict[tuple[str, str], TriedHabit] = {}
    watched: dict[str, None] = {}
    for habit in try_habits(days):
        yield None
        if isinstance(habit, FoundHabit):
            watched[name_of(habit)] = None
        elif habit is not None:
            key = habit.found.device, habit.found.when
            known = best.get(key)
            if known is None or known.precision + known.found.recall < habit.precision + habit.found.recall:
                best[key] = habit
    answer = SuggestHabitsResponse(
        success=True,
        proposals=(*map(proposal_of, best.values()), *_removals(made, entries)),
        watched=tuple(watched),
        searched=len(days.events),
        by_persons=sum(bool(event.step) for event in days.events),
        left_out=max(0, sum(len(history.words) for history in series) - MAX_HAPPENINGS),
        unnamed=sum(not words.reference(device.id) for device in devices),
    )
    yield from _free(series)
    yield from _free(entries)
    yield from _free(days.events)
    for kind in days.by_text.values():
        yield from _free(kind.times)
    yield answer


def _free(large: list[T]) -> Iterator[None]:
    """Empty *large* in slices: to free it at once would hold the event loop for 50 ms."""
    while large:
        del large[-100:]
        yield None


def _removals(made: Mapping[str, str], entries: Sequence[JournalEntry]) -> Iterator[HabitProposal]:
    """Yield the removal of each routine of a habit that people undo again and again."""
    for app, name in made.items():
        undone = undone_commands(entries, f"/{app}")
        if undone.undone >= UNDONE:
            proof = f"people undid {undone.undone} of its last {undone.given} commands within ten minutes"
            yield HabitProposal(id=f"remove/{app}", name=f"remove {name}", removes=name, proof=proof)


def _slice(search: Generator[SuggestHabitsResponse | None]) -> SuggestHabitsResponse | None:
    """Search for a while; return the answer at the end."""
    ends = perf_counter() + _SLICE
    for answer in search:
        if answer is not None or perf_counter() > ends:
            return answer
    return None


def start(node: Node, house: FeatureContext) -> HabitServices:
    """Return the server."""
    return HabitServices(node, house.home, house.store(_REJECTED), house.write_stores)
