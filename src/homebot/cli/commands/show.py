"""``homebot show``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Iterator

from homebot.cli.device_json import device_json
from homebot.cli.device_queries import house_time, named_device, reasons_for
from homebot.cli.door_client import DoorClient
from homebot.cli.table import printable
from homebot.cli.terminal import print_line, print_rows
from homebot.cli.thing_files import thing_text
from homebot.cli.time_format import ago
from homebot.cli.values import life, span, value_text
from homebot.cli.with_client import with_client
from homebot.devices import Device, DevicePart, State
from homebot.devices.capabilities import EVENTS
from homebot.devices.names import read_text_address
from homebot.devices.part import Capability

__all__ = ["show"]

_USES = {(True, True): "read and set", (True, False): "read", (False, True): "set", (False, False): ""}


def show(options: argparse.Namespace) -> int:
    """Print everything that is known of a device."""

    async def run(door: DoorClient) -> int:
        device = await named_device(door, options.device)
        if options.td:
            print(thing_text(device, options.broker))
        elif options.json:
            print(json.dumps(device_json(device), indent=2))
        else:
            reasons = await reasons_for(door, device)
            _describe(device, reasons, await house_time(door))
        return 0

    return with_client(options, run)


def _describe(device: Device, reasons: tuple[str, ...], now: float) -> None:
    """Print what is known of *device*.

    Args:
        device: The device.
        reasons: Why a search for its name finds it.
        now: The house's time.
    """
    print_line(f"{printable(device.id)}  {printable(device.name)}".rstrip(), "bold")
    print_rows([*_overview(device, now)])
    values = {(one.part, one.capability): one for one in (*device.states, *device.events)}
    for part in device.parts:
        title = _title(part) + (": unreachable" if part.id in device.offline_parts else "")
        _section(title, _part(part, values, now))
    endpoints = [one for one in device.endpoints if one.address or one.command_address]
    rows = [(one.gateway, "publishes on", one.address) for one in endpoints if _is_topic(one.address)]
    rows += [
        (one.gateway, "takes commands on", one.command_address) for one in endpoints if _is_topic(one.command_address)
    ]
    _section("addresses", rows)
    _section("identifiers", [(one,) for one in device.identifiers])
    facts = [
        (one.name, one.value, _by(one.gateway, one.convention, one.key), ago(one.said_at, now)) for one in device.facts
    ]
    facts = facts or [(one.key, one.value, "", "") for one in device.metadata]
    _section("facts", facts)
    _section("merged into one device, because", [(one,) for one in device.evidence])
    _section("disputed", [(one,) for one in device.conflicts])
    _section("found by its name, because", [(one,) for one in reasons])


def _overview(device: Device, now: float) -> Iterator[tuple[str, ...]]:
    yield "type", ", ".join(device.service_types) or device.service_type
    if device.area:
        yield "area", device.area
    others = [one for one in device.names if one != device.name]
    if others:
        yield "other names", ", ".join(others)
    seen = f"last seen {ago(device.last_seen, now)}, first {ago(device.first_seen, now)}"
    yield "availability", f"{life(device)}; {seen}"
    reach = {"yes": "yes", "no": "no", "unknown": "unknown"}[device.reachable.state]
    since = f", {ago(device.reachable.since, now)}" if device.reachable.since.sec else ""
    yield "reachable", f"{reach}: {device.reachable.why}{since}"


def _title(part: DevicePart) -> str:
    shown = part.part
    more = [f"“{shown.name}”"] if shown.name else []
    more += [f"part {part.id}"] if part.id else []
    more += [f"announced as {shown.advertised}"] if shown.advertised not in {"", shown.service_type} else []
    more += [one for one in (shown.tag, shown.category) if one]
    more += ["guessed"] if shown.guessed else []
    return f"{shown.service_type} ({', '.join(more)})" if more else shown.service_type


def _part(part: DevicePart, states: dict[tuple[str, str], State], now: float) -> Iterator[tuple[str, ...]]:
    for capability in part.part.capabilities:
        yield _capability(capability, states.get((part.id, capability.name)), now)
    yield from (("state topic", topic) for topic in part.part.reads)
    yield from (("command topic", topic) for topic in part.part.writes)
    for number, route in enumerate(part.routes):
        by = _by(route.gateway, route.convention, route.key)
        yield ("route" if number == 0 else "else"), by


def _capability(capability: Capability, state: State | None, now: float) -> tuple[str, ...]:
    use = _USES[capability.readable, capability.settable]
    value = state.value.plain() if state else None
    shown = "unknown" if capability.readable else "not reported"
    since = ""
    if state is not None and value is not None:
        shown = value_text(capability, value)
        kept = "" if state.live or capability.name in EVENTS else "retained, "
        since = f"{kept}{ago(state.since, now)}"
    return capability.name, shown, use, span(capability), since


def _section(title: str, rows: Iterable[tuple[str, ...]]) -> None:
    if shown := [*rows]:
        print()
        print_rows(shown, title)


def _by(gateway: str, convention: str, key: str) -> str:
    """As ``mqtt, homeassistant:light/0x17``; a key that begins with its convention says it once."""
    named = key if not convention or key.startswith(f"{convention}:") else f"{convention}:{key}"
    return f"via {gateway} as {named}" if gateway else f"as {named}"


def _is_topic(address: str) -> bool:
    return bool(address) and read_text_address(address) is None
