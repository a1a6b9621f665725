"""``homebot history``."""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from datetime import time as time_of_day
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import duration, whole
from homebot.cli.device_queries import device_or_similar, find_devices, house_time, print_note, why_none
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities
from homebot.cli.terminal import print_table
from homebot.devices.capabilities import CAPABILITIES, EVENTS
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.devices.wording.time_format import from_seconds
from homebot.devices.wording.values import value_text
from homebot.errors import PeerError, UsageError
from homebot.features.history import CORRECT_HISTORY, READ_ENERGY, READ_HISTORY
from homebot.support.names import did_you_mean
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.history_messages import CorrectHistoryResponse, EnergyOfDay, HistorySeries, ReadHistoryResponse

_ROWS = 24
_MATCHES = 50
_MAX_POINTS = 5000
_NARROWEST, _WIDEST = 40, 120
_DAY = 86_400.0
_BLOCKS = " ▁▂▃▄▅▆▇█"
_PLOT_LINES = 8
_LABEL = 9
_MAX_TIME = 8
"""Characters of a time without a date."""
_SEE_VALUES = "`homebot show DEVICE` lists those of a device"
_EXAMPLES = """\
  homebot history 'Kitchen lamp'
  homebot history 'temperature in kitchen' --since 7d --plot
  homebot history Washer --capability power --since 2h --csv
  homebot history --energy --since 30d
  homebot history correct Boiler temperature --from 14:00 --to 14:10 --drop
  homebot history correct Meter energy --from "2026-11-02 08:00" --to "2026-11-02 09:00" --value 812.4

Values are kept for 2 days, five-minute summaries for 30 days, and hourly summaries forever. If there are more rows than
--points, adjacent rows are combined. A pause is a time in which the value was unknown.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _history, _EXAMPLES)
    parser.add_argument("query", metavar="QUERY", nargs="*", help="a device by id or name, or a query as for `find`")
    parser.add_argument("--capability", metavar="NAME", default="", help="only this value, such as power")
    parser.add_argument("--since", metavar="SPAN", type=duration, help="the last SPAN, such as 2h or 7d (default: 24h)")
    parser.add_argument("--until", metavar="SPAN", type=duration, default=0.0, help="without the last SPAN")
    parser.add_argument("--points", metavar="N", type=whole, help="most rows for each value (default: 24, files 5000)")
    parser.add_argument("--energy", action="store_true", help="energy by device and day, in kWh (default: 7 days)")
    corrected = parser.add_argument_group("correct DEVICE CAPABILITY")
    corrected.add_argument("--from", metavar="TIME", dest="begin", default="", help="14:00 today, or 2026-11-02 14:00")
    corrected.add_argument("--to", metavar="TIME", dest="end", default="", help="the end, which is not corrected")
    corrected.add_argument("--part", metavar="ID", default="", help="the part, if several have the value")
    instead = corrected.add_mutually_exclusive_group()
    instead.add_argument("--drop", action="store_true", help="drop the numbers between")
    instead.add_argument("--value", metavar="N", type=float, help="set them to N")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--plot", action="store_true", help="draw numbers")
    form.add_argument("--csv", action="store_true", help="print comma-separated values, times in ISO 8601 UTC")
    form.add_argument("--json", action="store_true", help="print a JSON list, times in seconds since 1970")


def _history(door: DoorClient, options: argparse.Namespace) -> int:
    text = " ".join(options.query)
    if any((options.drop, options.value is not None, options.begin, options.end)):
        return _correct(door, options)
    if not text.strip() and not options.energy:
        raise UsageError("give a device or a query, such as 'temperature in kitchen'; --energy needs none")
    if options.plot and options.energy:
        raise UsageError("--plot is for values; --energy has a table, --csv and --json")
    since, until = _time_asked(door, options)
    request = _devices(door, text) | {"since": from_seconds(since), "until": from_seconds(until)}
    if options.energy:
        return _print_energy(_ask(door, READ_ENERGY.name, request), options)
    request |= {"capability": options.capability, "points": _points(options)}
    response, since = _series(door, request, since)
    if not response.series and (name := options.capability) and name not in CAPABILITIES:
        raise PeerError(f"nothing has a value {name!r}; {did_you_mean(name, CAPABILITIES, _SEE_VALUES)}")
    _print_history(response, options, since, until)
    return 0 if response.series else 1


def _points(options: argparse.Namespace) -> int:
    """Return the largest number of points of a series."""
    usual = _WIDEST if options.plot else _MAX_POINTS if options.csv or options.json else _ROWS
    return min(options.points or usual, _MAX_POINTS)


def _correct(door: DoorClient, options: argparse.Namespace) -> int:
    match options.query:
        case ["correct", name, capability] if options.begin and options.end:
            pass
        case _:
            raise UsageError("give: homebot history correct DEVICE CAPABILITY --from TIME --to TIME --drop")
    if not options.drop and options.value is None:
        raise UsageError("give --drop, or --value N")
    now = datetime.fromtimestamp(house_time(door)).astimezone()
    request = {
        "device": getattr(device_or_similar(door, name), "id", name),
        "part": options.part,
        "capability": capability,
        "since": from_seconds(_moment(options.begin, now)),
        "until": from_seconds(_moment(options.end, now)),
        "value": options.value or 0.0,
        "drops": options.drop,
    }
    count = cast("CorrectHistoryResponse", _ask(door, CORRECT_HISTORY.name, request)).count
    print(f"{count} number{'s' if count > 1 else ''} corrected")
    return 0


def _moment(text: str, now: datetime) -> float:
    """Return a local time as seconds since the Unix epoch; one without a date is of today."""
    try:
        if len(text) <= _MAX_TIME:
            return datetime.combine(now.date(), time_of_day.fromisoformat(text), now.tzinfo).timestamp()
        return datetime.fromisoformat(text).timestamp()
    except ValueError:
        raise UsageError(f"{text!r} is no time such as 14:00 or '2026-11-02 14:00'") from None


def _series(door: DoorClient, request: Mapping[str, object], since: float) -> tuple[ReadHistoryResponse, float]:
    """Return the series, and when they begin: of a young history, rows for the whole time would be few."""
    while True:
        response = cast("ReadHistoryResponse", _ask(door, READ_HISTORY.name, {**request, "since": from_seconds(since)}))
        begins = min((series.times[0] for series in response.series if series.times), default=since)
        if begins <= since:
            return response, since
        since = begins


def _print_history(found: ReadHistoryResponse, options: argparse.Namespace, since: float, until: float) -> None:
    if options.json:
        print(json.dumps([fields_of(series) for series in found.series]))
    elif options.csv:
        _print_csv(("time", "device", "part", "capability", "value", "low", "high", "until"), _csv_rows(found.series))
    else:
        _print_series(found, since, until, is_plot=options.plot)


def _time_asked(door: DoorClient, options: argparse.Namespace) -> tuple[float, float]:
    """Return the start and the end, in seconds since the Unix epoch by homebot's clock."""
    now = house_time(door)
    length = options.since or (6 * _DAY if options.energy else _DAY)
    since, until = max(0.0, now - length), max(0.0, now - options.until)
    if since >= until:
        raise UsageError("--until leaves nothing of --since; give a shorter one")
    return since, until


def _devices(door: DoorClient, text: str) -> dict[str, object]:
    """Return the request fields for the device called *text*, or else for the devices that match it as a query."""
    if not text:
        return {}
    device = device_or_similar(door, text)
    if not isinstance(device, list):
        return {"device": device.id}
    answer = find_devices(door, text, _MATCHES, is_spelled=True)
    if not answer.results:
        raise PeerError(why_none(answer, text))
    print_note(answer, as_json=door.as_json)
    return {"query": text}


def _ask(door: DoorClient, service: str, request: Mapping[str, object]) -> JsonMessage:
    try:
        return door.ask(service, request, 30.0)
    except PeerError as exc:
        if entities(door, kind="service", name=service):
            raise
        problem = "this homebot keeps no history; set `enabled = true` in [history] of its configuration to start one"
        raise PeerError(problem) from exc


def _print_series(found: ReadHistoryResponse, since: float, until: float, *, is_plot: bool) -> None:
    if not found.series:
        print("nothing is known about that time; a history begins shortly after homebot, and when a value changes")
    for number, series in enumerate(found.series):
        if number:
            print()
        part = f"#{series.part}" if series.part else ""
        print(
            f"{printable(series.name)}{printable(part)}  {series.capability}{f', {series.unit}' if series.unit else ''}"
        )
        if is_plot and series.values:
            width = max(min(shutil.get_terminal_size().columns, _WIDEST), _NARROWEST)
            print("\n".join(plot_lines(series.times, series.values, since, until, width)))
        else:
            _print_table(series, until - since)
    if found.left_out:
        print(f"\n… and {found.left_out} more values; --capability or a narrower query leaves some out")


def _print_table(one: HistorySeries, length: float) -> None:
    if one.words:
        flags = {"true": True, "false": False}
        rows = [
            (_clock(at, length), value_text(one.capability, flags.get(word, word)), _span_text(end - at))
            for at, word, end in zip(one.times, one.words, one.ends, strict=True)
        ]
        if one.capability in EVENTS:
            print_table(("TIME", "EVENT"), [row[:2] for row in rows])
        else:
            print_table(("SINCE", "STATE", "FOR"), rows)
        if not one.complete:
            print("… there are older ones; --points shows more")
    elif one.lows:
        print_table(
            ("TIME", "MEAN", "MIN", "MAX"),
            [
                (_clock(at, length), *map(_number, rest))
                for at, *rest in zip(one.times, one.values, one.lows, one.highs, strict=True)
            ],
        )
    else:
        print_table(
            ("TIME", "VALUE"),
            [(_clock(at, length), _number(value)) for at, value in zip(one.times, one.values, strict=True)],
        )


def _csv_rows(series: Sequence[HistorySeries]) -> Iterator[Sequence[object]]:
    for history in series:
        place = history.device, history.part, history.capability
        for number, at in enumerate(history.times):
            if history.words:
                yield _iso(at), *place, history.words[number], "", "", _iso(history.ends[number])
            elif history.lows:
                yield (
                    _iso(at),
                    *place,
                    history.values[number],
                    history.lows[number],
                    history.highs[number],
                    _iso(at + history.width),
                )
            else:
                yield _iso(at), *place, history.values[number], "", "", ""


def _print_energy(found: JsonMessage, options: argparse.Namespace) -> int:
    days = cast("list[EnergyOfDay]", found.days)
    if options.json:
        print(json.dumps([fields_of(row) for row in days]))
    elif options.csv:
        head = ("day", "device", "part", "used", "returned")
        _print_csv(head, [(row.day, row.device, row.part, row.used, row.returned) for row in days])
    elif days:
        rows = [(row.day, f"{row.name}{f'#{row.part}' if row.part else ''}", *_kwh(row)) for row in days]
        print_table(("DAY", "DEVICE", "USED KWH", "RETURNED KWH"), rows, if_any=("RETURNED KWH",))
    else:
        print("no device counted energy in that time")
    return 0 if days else 1


def _kwh(one: EnergyOfDay) -> tuple[str, str]:
    return f"{one.used:.3f}", f"{one.returned:.3f}" if one.returned else ""


def _print_csv(head: Sequence[str], rows: Iterator[Sequence[object]] | Sequence[Sequence[object]]) -> None:
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)


def _number(value: float) -> str:
    return f"{value:.6g}"


def _clock(at: float, length: float) -> str:
    form = "%H:%M:%S" if length <= _DAY else "%d %b %H:%M" if length <= 60 * _DAY else "%Y-%m-%d %H:%M"
    return datetime.fromtimestamp(at).astimezone().strftime(form)


def _iso(at: float) -> str:
    return datetime.fromtimestamp(at, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _span_text(seconds: float) -> str:
    for size, unit in ((_DAY, "d"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


def plot_lines(
    times: Sequence[float], values: Sequence[float], since: float, until: float, width: int, height: int = _PLOT_LINES
) -> list[str]:
    """Return a plot of the mean *values* from *since* to *until*, in seconds since 1970; a pause is left blank.

    Args:
        width: Characters of a line.
        height: Lines of the plot, without the axis.
    """
    columns = max(width - _LABEL - 2, 10)
    sums: dict[int, list[float]] = {}
    for at, value in zip(times, values, strict=True):
        column = min(int((at - since) / (until - since) * columns), columns - 1)
        sums.setdefault(max(column, 0), []).append(value)
    means = {column: sum(numbers) / len(numbers) for column, numbers in sums.items()}
    low, high = min(means.values(), default=0.0), max(means.values(), default=0.0)
    return [*_plot_rows(means, low, high, columns, height), _axis(since, until, columns)]


def _plot_rows(means: dict[int, float], low: float, high: float, columns: int, height: int) -> Iterator[str]:
    steps = len(_BLOCKS) - 1
    reach = (high - low) or 1.0
    filled = {column: 1 + round((mean - low) / reach * (height * steps - 1)) for column, mean in means.items()}
    for row in range(height - 1, -1, -1):
        label = f"{high:.5g}" if row == height - 1 else f"{low:.5g}" if row == 0 else ""
        signs = (_BLOCKS[min(max(filled.get(column, 0) - row * steps, 0), steps)] for column in range(columns))
        yield f"{label:>{_LABEL}} │{''.join(signs)}".rstrip()


def _axis(since: float, until: float, columns: int) -> str:
    form = "%H:%M" if until - since < _DAY else "%d %b %H:%M" if until - since <= 30 * _DAY else "%d %b %Y"
    first, last = (datetime.fromtimestamp(at).astimezone().strftime(form) for at in (since, until))
    return f"{'':{_LABEL}} └{first}{'─' * max(columns - len(first) - len(last), 1)}{last}"
