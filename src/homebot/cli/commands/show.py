"""``homebot show``."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from homebot.cli.arguments import add_broker_option
from homebot.cli.device_json import device_json, json_text
from homebot.cli.device_queries import (
    house_time,
    ineffective_routes,
    limits_of,
    named_device,
    reasons_for,
    unapproved,
)
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.capabilities import EVENTS
from homebot.devices.names import OWNER, PREFER, SEEN, TAG
from homebot.devices.wording.time_format import ago
from homebot.devices.wording.values import is_topic, life, plain_value, span, step_of, type_text, value_text
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device, DevicePart, Endpoint, Fact, Route, State
    from homebot.devices.part import Capability

_USES = {(True, True): "read and set", (True, False): "read", (False, True): "set", (False, False): ""}
_STATED_BY = {"configuration": ", in the configuration", "import": ", in an imported file"}

_EXAMPLES = """\
  homebot show lights/roomlights405
  homebot show 'Kitchen lamp'
  homebot show 'Kitchen lamp' --td > kitchen_lamp.td.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _show, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")
    form.add_argument("--td", action="store_true", help="print a W3C Thing Description 1.1")
    add_broker_option(parser)


def _show(door: DoorClient, options: argparse.Namespace) -> int:
    device = named_device(door, options.device)
    if options.td:
        from homebot.cli.commands.import_thing import thing_text, to_device  # noqa: PLC0415 - for Thing Descriptions alone

        print(thing_text(to_device(device), options.broker))
    elif options.json:
        print(json_text(device_json(device, unapproved(door, device.id))))
    else:
        reasons = reasons_for(door, device)
        limits = [(title, printable(text, 1000)) for title, text in limits_of(door, device)]
        now, ineffective = house_time(door), ineffective_routes(door, device)
        print_line(f"{printable(device.id)}  {printable(device.name)}".rstrip(), "bold")
        print_rows([*_overview(device, now), *limits])
        _print_parts(device, now, ineffective)
        if len(device.endpoints) > 1:
            _section("gateways", [_endpoint(endpoint, now) for endpoint in device.endpoints])
        rows = [(endpoint.gateway, "publishes on", endpoint.address) for endpoint in device.endpoints]
        rows += [(endpoint.gateway, "takes commands on", endpoint.command_address) for endpoint in device.endpoints]
        _section("addresses", [row for row in rows if is_topic(row[-1])])
        _section("identifiers", [(identifier,) for identifier in device.identifiers])
        _section("facts", _facts(device, now))
        _section("merged into one device, because", [(reason,) for reason in device.evidence])
        _section("disputed", [(conflict,) for conflict in device.conflicts])
        _section("why a search for its name finds it", [(reason,) for reason in reasons])
    return 0


def _print_parts(device: Device, now: float, ineffective: Collection[tuple[str, str]]) -> None:
    values = {(state.part, state.capability): state for state in (*device.states, *device.events)}
    prefer = next(
        (fact.value.split(", ") for fact in device.facts if (fact.name, fact.convention) == (PREFER, OWNER)), []
    )
    for part in device.parts:
        title = _title(part) + (": unreachable" if part.id in device.offline_parts else "")
        ranks = {gateway: f", number {number} that you prefer" for number, gateway in enumerate(prefer, 1)}
        late = {route for part_id, route in ineffective if part_id == part.id}
        _section(title, _part(part, values, ranks, late, now))


def _facts(device: Device, now: float) -> list[tuple[str, ...]]:
    facts: list[tuple[str, ...]] = [(fact.name, fact.value, _by(fact), ago(fact.said_at, now)) for fact in device.facts]
    return facts or [(item.key, item.value, "", "") for item in device.metadata]


def _overview(device: Device, now: float) -> Iterator[tuple[str, ...]]:
    yield "type", ", ".join(dict.fromkeys(map(type_text, device.service_types))) or device.service_type
    if device.area:
        outer = f" ({', '.join(device.outer_areas)})" if device.outer_areas else ""
        yield "area", device.area + outer
    if device.tags:
        yield "tags", ", ".join(device.tags)
    others = [name for name in device.names if name != device.name]
    if others:
        yield "other names", ", ".join(others)
    seen = f"last seen {ago(device.last_seen, now)}, first {ago(device.first_seen, now)}"
    yield "availability", f"{life(device)}; {seen}"
    reachable = device.reachable
    since = f", {ago(reachable.since, now)}" if reachable.since.sec else ""
    yield "reachable", f"{reachable.state}: {reachable.why}{since}"


def _title(part: DevicePart) -> str:
    shown = part.part
    more = [f"“{shown.name}”"] if shown.name else []
    more += [f"part {part.id}"] if part.id else []
    more += [f"announced as {shown.advertised}"] if shown.advertised not in {"", shown.service_type} else []
    more += [text for text in (shown.tag, shown.category) if text]
    more += ["guessed"] if shown.guessed else []
    name = type_text(shown.service_type)
    return f"{name} ({', '.join(more)})" if more else name


def _part(
    part: DevicePart,
    states: dict[tuple[str, str], State],
    ranks: Mapping[str, str],
    late: Collection[str],
    now: float,
) -> Iterator[tuple[str, ...]]:
    for capability in part.part.capabilities:
        yield _capability(capability, states.get((part.id, capability.name)), now)
    yield from (("state topic", topic) for topic in part.part.reads)
    yield from (("command topic", topic) for topic in part.part.writes)
    for number, route in enumerate(part.routes):
        note = "; its last commands had no effect" if f"{route.gateway}/{route.key}" in late else ""
        yield ("route" if number == 0 else "else"), _by(route) + ranks.get(route.gateway, "") + note


def _capability(capability: Capability, state: State | None, now: float) -> tuple[str, ...]:
    use = _USES[capability.readable, capability.settable]
    value = plain_value(state.value) if state else None
    shown = "unknown" if capability.readable else "not reported"
    since = ""
    if state is not None and value is not None:
        shown = value_text(capability.name, value, capability.unit, step_of(capability))
        kept = "" if state.live or capability.name in EVENTS else "retained, "
        since = f"{kept}{ago(state.since, now)}"
    return capability.name, shown, use, span(capability), since


def _endpoint(endpoint: Endpoint, now: float) -> tuple[str, ...]:
    reach = {"yes": "reachable", "no": "unreachable", "unknown": ""}[endpoint.reachable]
    life = ", ".join(text for text in (endpoint.freshness, reach) if text)
    if endpoint.claimed:
        life += ", unconfirmed: gets no commands"
    return endpoint.gateway, life, f"last seen {ago(endpoint.last_seen, now)}", f"as {endpoint.key}"


def _section(title: str, rows: Iterable[tuple[str, ...]]) -> None:
    if shown := [*rows]:
        print()
        print_rows(shown, title)


def _by(source: Route | Fact) -> str:
    """Return ``mqtt, homeassistant:light/0x17``; a convention at the beginning of the key is not repeated."""
    gateway, convention, key = source.gateway, source.convention, source.key
    if not gateway and convention == OWNER:
        return f"by the owner{_STATED_BY.get(key, '')}"
    if convention == TAG:
        return "as a robot saw it" if gateway == SEEN else f"by the tag {key} at {gateway}"
    named = key if not convention or key.startswith(f"{convention}:") else f"{convention}:{key}"
    return f"via {gateway} as {named}" if gateway else f"as {named}"
