"""``homebot doctor``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, cast

from homebot.cli.arguments import DEFAULT_CONFIG, set_client_command
from homebot.cli.device_queries import find_devices, house_time
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.findings import Finding, FindingKind, FindingRow, finding_json, print_finding
from homebot.cli.graph_queries import entities
from homebot.cli.publishing import GATEWAY_STATE, gateway_state
from homebot.cli.terminal import print_line
from homebot.devices.names import NEEDS_GATEWAY, NEXT_STEP, SENDS_NOTHING
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age, ago
from homebot.devices.wording.values import plain_value
from homebot.errors import LinkError, UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device, GatewayState
    from homebot.devices.health import Count, HealthResponse, PartFailure

__all__ = ["add_arguments", "gateway_finding", "health_findings"]

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

_ILLS = ("commands_failed", "failures", "dropped", "lost")
"""Those of them that are no matter of outsiders: one is enough for not all to be well."""

_MOST, _FEW = 20, 5
_WEAK_BATTERY = 20


_EXAMPLES = """\
  homebot doctor
  homebot doctor --json
  homebot doctor --offline --reach     before the start: configuration, files, ports, and whether servers accept it

The exit status is 1 if there are problems, or no homebot. Each line begins with a code; docs/operate.md lists them.
Some of the counts: `strays` are reports that came before the announcement
of their device; `holds`, how often a publisher waited for a slow client of the embedded broker; `unread given up`,
connections that it closed because a packet stayed incomplete; `answers late`, answers of services whose callers had
given up; `asks dropped`, requests for a device's state and
`expiries dropped`, values that expire (such as motion), that were too many to keep track of.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _doctor, _EXAMPLES)
    parser.add_argument("--gateways", action="store_true", help="ask only whether it runs and its gateways work")
    parser.add_argument("--counts", action="store_true", help="show all counters, not only those of problems")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--offline", action="store_true", help="check what homebot needs to start; it need not run")
    parser.add_argument("--config", metavar="FILE", help="with --offline: the configuration (default: homebot.toml)")
    parser.add_argument("--reach", action="store_true", help="with --offline: log in to broker or hub as well")


def _doctor(options: argparse.Namespace) -> int:
    if options.offline:
        return _check_offline(options)
    if options.config or options.reach:
        raise UsageError("--config and --reach are for --offline; a running homebot knows its configuration")
    try:
        return with_client(options, _ask)
    except LinkError as exc:
        raise LinkError(f"{exc}; `homebot doctor --offline` checks what it needs") from exc


def _check_offline(options: argparse.Namespace) -> int:
    from homebot.cli.offline_checks import offline_findings  # noqa: PLC0415 - loads the plug-ins

    file = Path(options.config or DEFAULT_CONFIG)
    findings = tuple(offline_findings(file, reaches=options.reach))
    return _show(f"checked {file} and what it needs", {"config": str(file)}, findings, options)


def _ask(door: DoorClient, options: argparse.Namespace) -> int:
    now = house_time(door)
    total, unconfirmed = (find_devices(door, query, 1).total for query in ("", "unconfirmed"))
    gateways, findings = _gateways(door), list[Finding]()
    texts = [f"home {printable(door.home)} on {door.where}"]
    texts += [] if gateways else ["no gateway runs: no device is found without a table such as [gateways.mqtt]"]
    for name, state in sorted(gateways.items()):
        texts += [_gateway_line(name, state)] if state is not None and state.state == "active" else []
        findings += gateway_finding(name, state)
    for name, health in () if options.gateways else sorted(_health(door).items()):
        findings += health_findings(name, health, now, everything=options.counts)
    lost = [name for name, state in sorted(gateways.items()) if state is not None and state.state != "active"]
    findings += () if options.gateways else _device_findings(door, now, lost)
    texts.append(f"devices: {total}, unconfirmed: {unconfirmed}")
    states = {name: "silent" if state is None else state.state for name, state in gateways.items()}
    facts = {"home": door.home, "door": door.where, "gateways": states, "devices": total, "unconfirmed": unconfirmed}
    return _show("\n".join(texts), facts, findings, options)


def _show(title: str, facts: Mapping[str, object], findings: Sequence[Finding], options: argparse.Namespace) -> int:
    findings = sorted(findings, key=lambda one: one.kind.is_problem)  # what matters is above the prompt
    is_well = not any(one.kind.is_problem for one in findings)
    if options.json:
        print(json.dumps({**facts, "is_well": is_well, "findings": finding_json(findings)}, indent=2))
        return 0 if is_well else 1
    print(title)
    for one in findings:
        print_finding(one)
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


def gateway_finding(name: str, state: GatewayState | None) -> Iterator[Finding]:
    """Yield the finding about a gateway that does not work."""
    if state is None:
        row = FindingRow("", f"gateway {name} does not report its state")
        yield Finding(FindingKind.SILENT_GATEWAY, f"gateway/{name}", (row,))
    elif state.state != "active":
        yield Finding(FindingKind.GATEWAY, f"gateway/{name}", (FindingRow("", _gateway_line(name, state)),))


def _gateway_line(name: str, state: GatewayState) -> str:
    acts = " and sends commands" if state.acts and state.reason != SENDS_NOTHING else " and only observes"
    reason = f": {state.reason}" if state.reason else ""
    return f"gateway {name} is {state.state}{acts if state.state == 'active' else ''}{reason}"


def health_findings(name: str, health: HealthResponse, now: float, *, everything: bool) -> Iterator[Finding]:
    """Yield the findings about a node.

    Args:
        everything: Whether counts are told that are no fault.
    """
    found: dict[FindingKind, list[FindingRow]] = {kind: [] for kind in _OF_A_NODE}
    for kind, row in _health_rows(health, now, everything=everything):
        found[kind].append(row)
    for kind, rows in found.items():
        if rows:
            yield Finding(kind, name, tuple(rows[:_MOST] if kind in _CUT else rows), len(rows))


_OF_A_NODE = (
    FindingKind.TROUBLE,
    FindingKind.NOTE,
    FindingKind.COUNT,
    FindingKind.LOSS,
    FindingKind.GIVEN_UP,
    FindingKind.FAILURE,
    FindingKind.QUARANTINE,
)
_CUT = {FindingKind.FAILURE, FindingKind.QUARANTINE}


def _health_rows(health: HealthResponse, now: float, *, everything: bool) -> Iterator[tuple[FindingKind, FindingRow]]:
    for text in health.troubles:
        yield FindingKind.TROUBLE, FindingRow("", text)
    for text in health.notes:
        yield FindingKind.NOTE, FindingRow("", text)
    yield from _count_rows(health.counts, everything=everything)
    for failure in health.failures:
        yield FindingKind.GIVEN_UP if failure.outcome == "given up" else FindingKind.FAILURE, _failure(failure, now)
    for one in health.quarantined:
        text = f"for {age(one.since, now)}, {one.offences} offences, the last: {one.why}"
        yield FindingKind.QUARANTINE, FindingRow(one.offender, text)


def _count_rows(counts: Iterable[Count], *, everything: bool) -> Iterator[tuple[FindingKind, FindingRow]]:
    for one in counts:
        is_listed = one.name == "callback_failures"  # each with its reason, as a failure
        if everything or (one.count and not is_listed and _is_one_of(_FAULTS, one.name)):
            kind = FindingKind.LOSS if one.count and _is_one_of(_ILLS, one.name) else FindingKind.COUNT
            yield kind, FindingRow(one.name.replace("_", " "), str(one.count))


def _failure(one: PartFailure, now: float) -> FindingRow:
    times = "once" if one.count == 1 else f"{one.count} times"
    outcome = f"; now {one.outcome}" if one.outcome else ""
    return FindingRow(one.part, f"{one.what} {times}, {ago(one.last, now)}: {one.why}{outcome}")


class _DeviceCheck(NamedTuple):
    """A question about all devices, and what is said of each that it finds.

    Attributes:
        most: How many are shown: a whole house takes long to carry.
    """

    kind: FindingKind
    query: str
    detail: Callable[[Device, float], str]
    most: int


def _device_findings(door: DoorClient, now: float, lost: Iterable[str]) -> Iterator[Finding]:
    """Yield the findings about devices; those of *lost* gateways are unreachable, as the finding about these says."""
    linked = "".join(f" not gateway={name}" for name in lost)
    for kind, query, detail, most in _DEVICE_CHECKS:
        asked = query + linked if kind is FindingKind.UNREACHABLE else query
        found = find_devices(door, asked, most)
        if found.total:
            devices = sorted((one.device for one in found.results), key=lambda one: one.id)
            rows = tuple(FindingRow(one.id, detail(one, now)) for one in devices)
            yield Finding(kind, "", rows, found.total, f"; all: homebot find --limit {found.total} '{asked}'")


def _dispute(device: Device, _now: float) -> str:
    more = len(device.conflicts) - 1
    return device.conflicts[0] + (f" (and {more} more: homebot show '{device.id}')" if more else "")


def _charge(device: Device, _now: float) -> str:
    values = {one.capability: plain_value(one.value) for one in device.states}
    return f"{values['battery']:.0f} %" if isinstance(values.get("battery"), int | float) else "it says so"


def _step(device: Device, _now: float) -> str:
    """Return the next step with what has a gateway of its own, rather than as a HomeKit accessory, which it may be."""
    needed = {(one.gateway, one.key): one.value for one in device.facts if one.name == NEEDS_GATEWAY}
    steps = [
        (needed.get((one.gateway, one.key)) == "homekit", one.value) for one in device.facts if one.name == NEXT_STEP
    ]
    return min(steps, default=(False, ""))[1]


_UNUSED = (
    f'"{NEEDS_GATEWAY}"=homeassistant or "{NEEDS_GATEWAY}"=hue '
    f'or ("{NEEDS_GATEWAY}"=homekit and not "dns_sd_type"=_hue._tcp)'
)

_DEVICE_CHECKS = (
    _DeviceCheck(FindingKind.STALE, "stale", lambda one, now: f"last seen {ago(one.last_seen, now)}", _MOST),
    _DeviceCheck(FindingKind.UNREACHABLE, "offline not stale", lambda one, _now: one.reachable.why, _MOST),
    _DeviceCheck(FindingKind.DISPUTED, "disputed", _dispute, _MOST),
    _DeviceCheck(FindingKind.BATTERY, f"battery < {_WEAK_BATTERY} or battery_low=yes", _charge, _FEW),
    _DeviceCheck(FindingKind.NO_GATEWAY, _UNUSED, _step, _MOST),
    _DeviceCheck(FindingKind.NO_ROOM, "without area", lambda one, _now: one.name, _FEW),
)


def _is_one_of(faults: tuple[str, ...], name: str) -> bool:
    return any(name == fault or name.endswith(f"_{fault}") or name.startswith(f"{fault}_") for fault in faults)
