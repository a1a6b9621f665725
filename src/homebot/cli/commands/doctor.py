"""``homebot doctor``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from homebot.cli.device_queries import find_devices, house_time
from homebot.cli.directory import entities
from homebot.cli.door_client import DoorClient
from homebot.cli.publishing import gateway_state
from homebot.cli.table import printable
from homebot.cli.terminal import print_line, print_rows
from homebot.cli.time_format import age, ago
from homebot.cli.with_client import with_client
from homebot.devices import Device, GatewayState
from homebot.devices.health import Count, GetHealth, HealthResponse, PartFailure, Quarantine
from homebot.messages.json import message_from_json

__all__ = ["doctor"]

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
)
"""How the names of counts begin or end that should be 0."""

_ILLS = ("commands_refused", "commands_failed", "failures", "dropped", "lost")
"""Those of them that are no matter of outsiders: one is enough for not all to be well."""

_MOST = 20


def doctor(options: argparse.Namespace) -> int:
    """Print how everything is; return 1 where something is not as it should be."""

    async def run(door: DoorClient) -> int:
        now = await house_time(door)
        is_well = True
        for name, state in sorted((await _gateways(door)).items()):
            is_well = _print_gateway(name, state) and is_well
        for name, health in sorted((await _health(door)).items()):
            is_well = _print_health(name, health, now, everything=options.counts) and is_well
        is_well = await _print_devices(door, now) and is_well
        print()
        print_line("all is well" if is_well else "problems found, see above", "bold green" if is_well else "bold red")
        return 0 if is_well else 1

    return with_client(options, run)


async def _gateways(door: DoorClient) -> dict[str, GatewayState | None]:
    topics = {one.name for one in await entities(door, kind="publisher") if one.type == GatewayState.ros_type}
    names = {topic.split("/")[2] for topic in topics if topic.startswith("/gateway/") and topic.endswith("/state")}
    return {name: await gateway_state(door, name) for name in names}


async def _health(door: DoorClient) -> dict[str, HealthResponse]:
    services = [one.name for one in await entities(door, kind="service") if one.type == GetHealth.ros_type]
    return {
        name.removesuffix("/health").strip("/"): message_from_json(HealthResponse, await door.call(name))
        for name in services
    }


def _print_gateway(name: str, state: GatewayState | None) -> bool:
    if state is None:
        print(f"gateway {name} does not report its state")
        return False
    acts = "sends commands" if state.acts else "only observes"
    print(f"gateway {name} is {state.state} and {acts}{f': {printable(state.reason)}' if state.reason else ''}")
    return state.state == "active"


def _print_health(name: str, health: HealthResponse, now: float, *, everything: bool) -> bool:
    for problem in health.troubles:
        print(f"problem of {name}: {printable(problem)}")
    for note in health.notes:
        print(f"note on {name}: {printable(note)}")
    shown = [one for one in health.counts if everything or (one.count and _is_one_of(_FAULTS, one))]
    _print_section(
        f"counted by {name} since it started", [(one.name.replace("_", " "), str(one.count)) for one in shown]
    )
    failures = [_failure(one, now) for one in health.failures[:_MOST]]
    _print_section(f"failures in {name} since it started", failures, len(health.failures))
    offenders = [_quarantine(one, now) for one in health.quarantined[:_MOST]]
    _print_section(
        f"quarantined by {name}, which reads only some of their messages", offenders, len(health.quarantined)
    )
    is_ill = any(one.count and _is_one_of(_ILLS, one) for one in health.counts)
    return not (health.quarantined or health.troubles or health.failures or is_ill)


def _failure(one: PartFailure, now: float) -> tuple[str, ...]:
    times = "once" if one.count == 1 else f"{one.count} times"
    outcome = f"; now {one.outcome}" if one.outcome else ""
    return one.part, f"{one.what} {times}, {ago(one.last, now)}: {one.why}{outcome}"


def _quarantine(one: Quarantine, now: float) -> tuple[str, ...]:
    return one.offender, f"for {age(one.since, now)}", f"{one.offences} offences, the last: {one.why}"


async def _print_devices(door: DoorClient, now: float) -> bool:
    """Ask for numbers, and for the devices that are shown: a whole house takes long to carry."""
    total = (await find_devices(door, "", 1)).total
    print(f"devices: {total}, unconfirmed: {(await find_devices(door, 'unconfirmed', 1)).total}")
    is_well = True
    for title, query, detail in (
        ("stale", "stale", lambda one: f"last seen {ago(one.last_seen, now)}"),
        ("unreachable", "offline not stale", lambda one: one.reachable.why),
        ("disputed", "disputed", _dispute),
    ):
        found = await find_devices(door, query, _MOST)
        devices = sorted((one.device for one in found.results), key=lambda one: one.id)
        hint = f"; all: homebot find --limit {found.total} '{query}'"
        _print_section(title, [(one.id, detail(one)) for one in devices], found.total, hint)
        is_well = is_well and not found.total
    return is_well


def _dispute(device: Device) -> str:
    more = len(device.conflicts) - 1
    return device.conflicts[0] + (f" (and {more} more: homebot show '{device.id}')" if more else "")


def _print_section(title: str, rows: Sequence[tuple[str, ...]], total: int = 0, hint: str = "") -> None:
    """Print *rows*, and how many of the *total* they are where there are more."""
    print_rows(rows, f"{title}:")
    if total > len(rows):
        print(f"  … the first {len(rows)} of {total} are shown{hint}")


def _is_one_of(faults: tuple[str, ...], one: Count) -> bool:
    return any(
        one.name == fault or one.name.endswith(f"_{fault}") or one.name.startswith(f"{fault}_") for fault in faults
    )
