"""``homebot doctor``."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import find_devices, house_time
from homebot.cli.door_client import DoorClient, door_command
from homebot.cli.graph_queries import entities
from homebot.cli.publishing import GATEWAY_STATE, gateway_state
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.names import SENDS_NOTHING
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age, ago
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device, GatewayState
    from homebot.devices.health import Count, HealthResponse, PartFailure, Quarantine

__all__ = ["add_arguments", "print_gateway", "print_health"]

_GET_HEALTH = "homebot/srv/GetHealth"

_FAULTS = (
    "rejected",
    "refused",
    "failed",
    "dropped",
    "oversize",
    "failures",
    "ignored",
    "deferred",
    "quarantines",
    "damaged",
    "cut",
    "lost",
    "late",
)
"""How the names of counts begin or end that should be 0."""

_ILLS = ("commands_refused", "commands_failed", "failures", "dropped", "lost")
"""Those of them that are no matter of outsiders: one is enough for not all to be well."""

_MOST = 20


_EXAMPLES = """\
  homebot doctor
  homebot doctor --counts

The exit status is 1 if there are problems. Some of the counts: `strays` are reports that came before the announcement
of their device; `holds`, how often a publisher waited for a slow client of the embedded broker; `unread given up`,
connections that it closed because a packet stayed incomplete; `answers late`, answers of services whose callers had
given up; `asks dropped`, requests for a device's state and
`expiries dropped`, values that expire (such as motion), that were too many to keep track of.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot doctor``."""
    set_client_command(parser, _doctor, _EXAMPLES)
    parser.add_argument("--counts", action="store_true", help="show all counters, not only those of problems")


@door_command
def _doctor(door: DoorClient, options: argparse.Namespace) -> int:
    """Print how everything is; return 1 where something is not as it should be."""
    now = house_time(door)
    print(f"home {printable(door.home)} on {door.where}")
    is_well = True
    for name, state in sorted(_gateways(door).items()):
        is_well = print_gateway(name, state) and is_well
    for name, health in sorted(_health(door).items()):
        is_well = print_health(name, health, now, everything=options.counts) and is_well
    is_well = _print_devices(door, now) and is_well
    print()
    print_line("all is well" if is_well else "problems found, see above", "bold green" if is_well else "bold red")
    return 0 if is_well else 1


def _gateways(door: DoorClient) -> dict[str, GatewayState | None]:
    topics = {one.name for one in entities(door, kind="publisher") if one.type == GATEWAY_STATE}
    names = {topic.split("/")[2] for topic in topics if topic.startswith("/gateway/") and topic.endswith("/state")}
    return {name: gateway_state(door, name) for name in names}


def _health(door: DoorClient) -> dict[str, HealthResponse]:
    services = [one.name for one in entities(door, kind="service") if one.type == _GET_HEALTH]
    answers = {name: JsonMessage(door.call(name)) for name in services}
    return {name.removesuffix("/health").strip("/"): cast("HealthResponse", one) for name, one in answers.items()}


def print_gateway(name: str, state: GatewayState | None) -> bool:
    """Print how a gateway is; return whether it works."""
    if state is None:
        print(f"gateway {name} does not report its state")
        return False
    is_active = state.state == "active"
    acts = " and sends commands" if state.acts and state.reason != SENDS_NOTHING else " and only observes"
    reason = f": {printable(state.reason)}" if state.reason else ""
    print(f"gateway {name} is {state.state}{acts if is_active else ''}{reason}")
    return is_active


def print_health(name: str, health: HealthResponse, now: float, *, everything: bool) -> bool:
    """Print the problems of a node; return whether all is well there."""
    for problem in health.troubles:
        print(f"problem of {name}: {printable(problem)}")
    for note in health.notes:
        print(f"note on {name}: {printable(note)}")
    counts = health.counts if everything else _faults(health.counts)
    _print_section(f"counted by {name} since it started", [_count(one) for one in counts])
    failures = [_failure(one, now) for one in health.failures[:_MOST]]
    _print_section(f"failures in {name} since it started", failures, len(health.failures))
    offenders = [_quarantine(one, now) for one in health.quarantined[:_MOST]]
    _print_section(
        f"quarantined by {name}, which reads only some of their messages", offenders, len(health.quarantined)
    )
    is_ill = any(map(_is_ill, health.counts))
    return not (health.quarantined or health.troubles or health.failures or is_ill)


def _faults(counts: Iterable[Count]) -> list[Count]:
    return [one for one in counts if one.count and _is_one_of(_FAULTS, one.name)]


def _is_ill(one: Count) -> bool:
    return bool(one.count) and _is_one_of(_ILLS, one.name)


def _count(one: Count) -> tuple[str, ...]:
    """Return a row of the table of counts, with a word beside a count that is a problem by itself."""
    more = "; homebot journal tells more" if one.name.startswith("commands_") else ""
    hint = (f"a problem{more}",) if _is_ill(one) else ()
    return one.name.replace("_", " "), str(one.count), *hint


def _failure(one: PartFailure, now: float) -> tuple[str, ...]:
    times = "once" if one.count == 1 else f"{one.count} times"
    outcome = f"; now {one.outcome}" if one.outcome else ""
    return one.part, f"{one.what} {times}, {ago(one.last, now)}: {one.why}{outcome}"


def _quarantine(one: Quarantine, now: float) -> tuple[str, ...]:
    return one.offender, f"for {age(one.since, now)}", f"{one.offences} offences, the last: {one.why}"


def _print_devices(door: DoorClient, now: float) -> bool:
    """Ask for numbers, and for the devices that are shown: a whole house takes long to carry."""
    total = find_devices(door, "", 1).total
    print(f"devices: {total}, unconfirmed: {find_devices(door, 'unconfirmed', 1).total}")
    is_well = True
    for title, query, detail in (
        ("stale", "stale", lambda one: f"last seen {ago(one.last_seen, now)}"),
        ("unreachable", "offline not stale", lambda one: one.reachable.why),
        ("disputed", "disputed", _dispute),
    ):
        found = find_devices(door, query, _MOST)
        total = found.total
        devices = sorted((one.device for one in found.results), key=lambda one: one.id)
        hint = f"; all: homebot find --limit {total} '{query}'"
        _print_section(title, [(one.id, detail(one)) for one in devices], total, hint)
        is_well = is_well and not total
    return is_well


def _dispute(device: Device) -> str:
    more = len(device.conflicts) - 1
    return device.conflicts[0] + (f" (and {more} more: homebot show '{device.id}')" if more else "")


def _print_section(title: str, rows: Sequence[tuple[str, ...]], total: int = 0, hint: str = "") -> None:
    """Print *rows*, and how many of the *total* they are where there are more."""
    print_rows(rows, f"{title}:")
    if total > len(rows):
        print(f"  … the first {len(rows)} of {total} are shown{hint}")


def _is_one_of(faults: tuple[str, ...], name: str) -> bool:
    return any(name == fault or name.endswith(f"_{fault}") or name.startswith(f"{fault}_") for fault in faults)
