"""Services of the history: values, states, and energy by day."""

from collections.abc import Collection, Iterable, Mapping
from datetime import datetime, timedelta, tzinfo
from typing import Final, NamedTuple, final

from homebot.devices.device import Device
from homebot.devices.history_messages import (
    METER_OF_THE_HOUSE,
    CorrectHistoryRequest,
    CorrectHistoryResponse,
    EnergyOfDay,
    HistorySeries,
    ReadEnergyRequest,
    ReadEnergyResponse,
    ReadHistoryRequest,
    ReadHistoryResponse,
)
from homebot.devices.names import FIND_DEVICES
from homebot.devices.query.term_messages import QueryTerm, query_terms, read_terms
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.errors import LinkError, ServiceError
from homebot.features.history.batch import Series
from homebot.features.history.buckets import COUNTERS
from homebot.features.history.collector import Collector
from homebot.features.history.correction import Correction
from homebot.features.history.history_file import HistoryStore
from homebot.features.history.reading import HistoryReader, Numbers, Span, StoredStates
from homebot.graph import Node
from homebot.messages import Time
from homebot.support.folding import fold
from homebot.support.names import did_you_mean
from homebot.words.queries import parse_query

_NOTHING: Final = (
    "there are no numbers in that time, or only summaries of a longer one: "
    "older numbers are kept as five minutes, then as hours"
)
CORRECTED: Final = "history.corrected"
_DAY: Final = 86_400.0
_POINTS: Final = 500
_MAX_SERIES: Final = 50
_DIGITS: Final = 6
_NOT_YET: Final = "the history has not begun yet, or is not kept now; `homebot doctor` says why"


_TIMES: Final = {"day": "%Y-%m-%d", "month": "%Y-%m"}


class _FoundSeries(NamedTuple):
    series: list[Series]
    names: Mapping[str, str]
    devices: Mapping[str, Device]


@final
class HistoryService:
    """Serves the history.

    Args:
        zone: The time zone of the home; None for the computer's.

    Attributes:
        collector: The series and the unwritten values; None before the file is open.
    """

    def __init__(self, node: Node, store: HistoryStore, zone: tzinfo | None) -> None:
        self._clock, self._log = node.graph.clock, node.log
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._store = store
        self._zone = zone
        self.collector: Collector | None = None

    async def read(self, request: ReadHistoryRequest) -> ReadHistoryResponse:
        """Return the history of the devices that fit *request*."""
        if self.collector is None:
            return ReadHistoryResponse(success=False, message=self._store.kept.problem or _NOT_YET)
        since, until = self._bounds(request.since, request.until, _DAY)
        if since >= until:
            return ReadHistoryResponse(success=False, message="since must be before until")
        try:
            matches = await self._series(self.collector, request.device, request.query)
            wanted = [
                candidate
                for candidate in matches.series
                if request.part in {"", candidate.place[1]} and request.capability in {"", candidate.place[2]}
            ]
            span = Span(round(since * 1000), round(until * 1000), request.points or _POINTS)
            series = await self._store.read(
                self.collector, lambda reader: _read(reader, wanted[:_MAX_SERIES], matches.names, span)
            )
        except (LinkError, ServiceError) as exc:
            return ReadHistoryResponse(success=False, message=str(exc))
        return ReadHistoryResponse(
            success=True,
            series=tuple(series),
            left_out=max(len(wanted) - _MAX_SERIES, 0),
            since=Time.from_seconds(since),
            until=Time.from_seconds(until),
        )

    async def energy(self, request: ReadEnergyRequest) -> ReadEnergyResponse:
        """Return the energy of each day of the home that *request* touches."""
        if self.collector is None:
            return ReadEnergyResponse(success=False, message=self._store.kept.problem or _NOT_YET)
        since, until = self._bounds(request.since, request.until, 6 * _DAY)
        local = datetime.fromtimestamp(since, self._zone)
        midnight = local.replace(hour=0, minute=0, second=0, microsecond=0, fold=0)
        if midnight.timestamp() > since:  # the clocks were set back to midnight
            midnight -= timedelta(days=1)
        span = Span(round(midnight.timestamp() * 1000), round(until * 1000), 1)
        try:
            matches = await self._series(self.collector, request.device, request.query)
            counters = [counter for counter in matches.series if counter.place[2] in COUNTERS]
            if request.by != "device":
                meters = {
                    device.id for device in matches.devices.values() if METER_OF_THE_HOUSE in map(fold, device.tags)
                }
                counters = [counter for counter in counters if counter.place[0] not in meters]
            days = await self._store.read(
                self.collector, lambda reader: _energy(reader, counters, matches, span, self._zone, request)
            )
        except (LinkError, ServiceError) as exc:
            return ReadEnergyResponse(success=False, message=str(exc))
        return ReadEnergyResponse(success=True, days=tuple(days))

    async def correct(self, request: CorrectHistoryRequest) -> CorrectHistoryResponse:
        """Correct the numbers in *request*, and log it, as nothing else changes what is stored."""
        if self.collector is None:
            return CorrectHistoryResponse(success=False, message=self._store.kept.problem or _NOT_YET)
        since, until = _milliseconds(request.since), _milliseconds(request.until)
        series = [candidate for candidate in self.collector.series.values() if candidate.place[0] == request.device]
        meant = [candidate for candidate in series if _is_meant(candidate.place, request)]
        if problem := _problem(request, series, meant, is_span=since < until):
            return CorrectHistoryResponse(success=False, message=problem)
        value = None if request.drops else request.value
        try:
            count = await self._store.correct(self.collector, Correction(meant[0].number, since, until, value))
        except LinkError as exc:
            return CorrectHistoryResponse(success=False, message=str(exc))
        if not count:
            return CorrectHistoryResponse(success=False, message=_NOTHING)
        done = "dropped" if value is None else f"set to {value:g}"
        text = f"{count} numbers of {request.capability} of {request.device} were {done} on request"
        self._log.info(CORRECTED, message=text, device=request.device, capability=request.capability, count=count)
        return CorrectHistoryResponse(success=True, message=text, count=count)

    def _bounds(self, since: Time, until: Time, length: float) -> tuple[float, float]:
        end = until.to_seconds() or self._clock.now()
        return since.to_seconds() or end - length, end

    async def _series(self, collector: Collector, device: str, query: tuple[QueryTerm, ...]) -> _FoundSeries:
        """Return the series of the devices that fit, main values first unless others are named."""
        request = FindDevicesRequest(ids=(device,)) if device else FindDevicesRequest(query=query, is_checked=True)
        devices = {known.id: known for known in (await self._find.call(request)).devices}
        ids = {device} if device else devices.keys()
        series = sorted(
            (candidate for candidate in collector.series.values() if candidate.place[0] in ids),
            key=lambda candidate: candidate.place,
        )
        named = {term.name for term in query_terms(read_terms(query, parse_query))}
        if asked := [candidate for candidate in series if candidate.place[2] in named]:
            series = asked
        names = {key: device.name for key, device in devices.items()}
        return _FoundSeries(_main_first(series, devices), names, devices)


def _milliseconds(time: Time) -> int:
    return round(time.to_seconds() * 1000)


def _is_meant(place: tuple[str, str, str], request: CorrectHistoryRequest) -> bool:
    _, part, name = place
    return name == request.capability and request.part in {"", part}


def _problem(
    request: CorrectHistoryRequest, series: Collection[Series], meant: Collection[Series], *, is_span: bool
) -> str:
    """Return why *request* is not carried out, in words; empty if it is."""
    if not is_span:
        return "the start must be before the end"
    names = [candidate.place[2] for candidate in series]
    if not names:
        return f"there is no history of {request.device!r}; `homebot devices` lists the ids"
    if not meant:
        hint = did_you_mean(request.capability, names, f"it has {', '.join(sorted(set(names)))}")
        return f"{request.device} has no history of {request.capability!r}; {hint}"
    if len(meant) > 1:
        parts = ", ".join(repr(candidate.place[1]) for candidate in meant)
        return f"several parts of {request.device} have {request.capability}: {parts}; name one with --part"
    return ""


def _main_first(series: Iterable[Series], devices: Mapping[str, Device]) -> list[Series]:
    """Return *series* with the power of each device before its others, and those of settings and diagnostics last."""

    def is_aside(one: Series) -> bool:
        device = devices.get(one.place[0])
        part = None if device is None else device.part(one.place[1])
        return part is not None and bool(part.part.category)

    return sorted(series, key=lambda one: (is_aside(one), one.place[0], one.place[2] != "power"))


def _read(reader: HistoryReader, wanted: Iterable[Series], names: Mapping[str, str], span: Span) -> list[HistorySeries]:
    histories = []
    numbers = reader.numbers([series.number for series in wanted], span)
    for series in wanted:
        device, part, capability = series.place
        empty = HistorySeries(device=device, name=names.get(device, device), part=part, capability=capability)
        if series.number in numbers:
            histories.append(_with_numbers(empty, series.unit, numbers[series.number]))
        states = reader.states(series.number, span)
        if states.rows:
            histories.append(_with_states(empty, states, span))
    return histories


def _with_numbers(empty: HistorySeries, unit: str, numbers: Numbers) -> HistorySeries:
    buckets = numbers.buckets
    is_summary = numbers.width > 0
    return empty.model_copy(
        update={
            "unit": unit,
            "width": numbers.width / 1000,
            "times": tuple(at / 1000 for at in numbers.times),
            "values": tuple(_round(bucket.mean) if is_summary else bucket.mean for bucket in buckets),
            "lows": tuple(bucket.low for bucket in buckets) if is_summary else (),
            "highs": tuple(bucket.high for bucket in buckets) if is_summary else (),
        }
    )


def _with_states(empty: HistorySeries, states: StoredStates, span: Span) -> HistorySeries:
    flags = {0: "false", 1: "true"}
    return empty.model_copy(
        update={
            "times": tuple(max(at, span.since) / 1000 for at, _ in states.rows),
            "words": tuple(flags[row.value] if isinstance(row.value, int) else row.value for _, row in states.rows),
            "ends": tuple(min(row.until or span.until, span.until) / 1000 for _, row in states.rows),
            "complete": states.is_complete,
        }
    )


def _energy(
    reader: HistoryReader,
    counters: Iterable[Series],
    found_series: _FoundSeries,
    span: Span,
    zone: tzinfo | None,
    request: ReadEnergyRequest,
) -> list[EnergyOfDay]:
    by_day: dict[tuple[str, str, str], dict[str, float]] = {}
    places = {counter.number: counter.place for counter in counters}
    for number, at, rise in reader.rises(places, span, zone):
        device, part, capability = places[number]
        local = datetime.fromtimestamp(at / 1000, zone)
        if request.step == "hour":
            time = local.astimezone(zone).isoformat(timespec="hours")  # the offset tells the two hours of a set clock
        else:
            time = local.strftime(_TIMES[request.step])
        if request.by == "device":
            key = time, device, part
        else:  # the room stands in the place of the part
            known = found_series.devices.get(device)
            key = time, "", known.area if request.by == "room" and known is not None else ""
        sums = by_day.setdefault(key, {})
        sums[capability] = sums.get(capability, 0.0) + rise
    return [
        EnergyOfDay(
            day=day,
            device=device,
            name=found_series.names.get(device, device) if request.by == "device" else part,
            part=part if request.by == "device" else "",
            used=_round(sums.get("energy", 0.0)),
            returned=_round(sums.get("energy_returned", 0.0)),
        )
        for (day, device, part), sums in sorted(by_day.items())
    ]


def _round(number: float) -> float:
    return float(f"{number:.{_DIGITS}g}")
