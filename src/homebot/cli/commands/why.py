"""``homebot why`` and ``homebot why-not``."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Literal, cast

from homebot.cli.device_json import json_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.journal_client import JournalClient, chain_json
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.names import EXPLAIN_DEVICE, EXPLAIN_MISSING_STATE, UNREADABLE
from homebot.devices.wording.journal_words import (
    Chain,
    ago_text,
    chain_lines,
    chains_of,
    clock_text,
    finding_text,
    issuer_text,
    result_text,
    trigger_text,
    was_obeyed,
)
from homebot.devices.wording.time_format import iso
from homebot.devices.wording.values import state_text
from homebot.errors import PeerError, UsageError
from homebot.feature import all_features, load
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.journal_messages import (
        ExplainDeviceResponse,
        ExplainMissingStateResponse,
    )

_MAX_DEVICES = 10

_EXAMPLES = """\
  homebot why 'Hall lamp'
  homebot why lights/roomlights405 --json

Explains the state of a device: its last change, the program that asked for it, the cause, and the device's answer. If
no command explains the change, it was made by hand, or by the device itself. Of a robot, also routines that sent it; of
a routine or scene, what it did last.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _why, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name; or that of a routine or scene")
    parser.add_argument("state", nargs="?", help=argparse.SUPPRESS)
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


def add_why_not_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot why-not 'Hall lamp' on
  homebot why-not 'Front door' locked --json

Lists the commands that asked a device for a state, with their outcomes; or says that nobody asked for it, that the
device is already in that state, or that it has no such state.
"""
    set_door_command(parser, _why_not, examples)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("state", metavar="STATE", help="the state it is not in: on, off, open, locked, 40, cleaning, …")
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


def _why(door: DoorClient, options: argparse.Namespace) -> int:
    if options.state:
        asked = f"homebot why-not {shlex.quote(options.device)} {shlex.quote(options.state)}"
        raise UsageError(f"a state is asked for by `{asked}`")
    added = [] if options.json else _told_by_features("adds_to_why", door, options.device)
    try:
        device = named_device(door, options.device)
    except PeerError:
        explainers = (load(feature.explains) for feature in all_features() if feature.explains)
        named = argparse.Namespace(name=options.device, json=False)
        for show in () if options.json else explainers:
            with suppress(PeerError, UsageError):
                return int(show(door, named))
        if not added:  # robots need not be devices
            raise
        _print_lines(added)
        return 0
    client = JournalClient(door, device)
    response = cast("ExplainDeviceResponse", client.ask(EXPLAIN_DEVICE, {"device": device.id}))
    if options.json:
        print(json_text(_json(device, response, client)))
    else:
        _print(device, response, client, house_time(door))
        _print_lines(added)
    return 0


def _told_by_features(hook: Literal["adds_to_why", "adds_to_why_not"], door: DoorClient, name: str) -> list[str]:
    """Return the lines that features add about the device or robot *name*."""
    paths = [path for feature in all_features() if (path := getattr(feature, hook))]
    return [line for path in paths for line in load(path)(door, name)]


def _print_lines(lines: Sequence[str]) -> None:
    for line in lines:
        print_line(line)


def _print(device: Device, response: ExplainDeviceResponse, client: JournalClient, now: float) -> None:
    _print_state(device)
    print(finding_text(response, client.names, now))
    chains = chains_of(response.entries)
    if chains and response.finding not in {"change", "event"}:
        print()
        print_rows([*chain_lines(chains, client.names, now)])
    for fight in response.fights:
        print_line(f"{printable(fight.text)}, the last {ago_text(fight.newest, now)}.", "yellow")
    for fact in device.facts:
        if fact.name == UNREADABLE:
            print_line(f"Not understood, {ago_text(fact.said_at, now)}: {printable(fact.value, 400)}.", "yellow")
    for route in dict.fromkeys(item.value for item in response.ineffective):
        print_line(f"The last commands via {printable(route)} had no effect: another route is tried first.", "yellow")


def _json(device: Device, response: ExplainDeviceResponse, client: JournalClient) -> dict[str, object]:
    return {
        "device": device.id,
        "name": device.name,
        "state": state_text(device),
        "since": iso(response.changed_at) if response.changed_at.sec else None,
        "explained": response.finding == "command",
        "chain": chain_json(response.entries, client.names) if response.finding != "none" else [],
        "ineffective_routes": [{"part": item.key, "route": item.value} for item in response.ineffective],
        "fights": [
            {"apps": list(fight.issuers), "text": fight.text, "last": iso(fight.newest)} for fight in response.fights
        ],
    }


def _why_not(door: DoorClient, options: argparse.Namespace) -> int:
    if not options.state.strip():
        raise UsageError("give the state that the device is not in, such as on, open or 40")
    device = named_device(door, options.device)
    client = JournalClient(door, device)
    request = {"device": device.id, "state": options.state}
    response = cast("ExplainMissingStateResponse", client.ask(EXPLAIN_MISSING_STATE, request))
    asked = chains_of(response.entries)
    if options.json:
        chains = [chain_json(chain, client.names) for chain in asked]
        shown = {"device": device.id, "state": state_text(device), "wanted": options.state}
        print(json_text({**shown, "is_so": response.is_so, "asked": chains}))
    else:
        requests, now = chains_of(response.entries), house_time(door)
        _print_state(device)
        if response.is_so:
            print(f"It is already {_wanted(options)}; `homebot why {_quote(device)}` tells why.")
        if requests:
            most = 1 if response.is_so else _MAX_DEVICES
            times = "once" if len(requests) == 1 else f"{len(requests)} times"
            print(f"{_wanted(options)} was asked for {times}:")
            print()
            print_rows([_row(chain, client, now) for chain in requests[-most:]])
            if len(requests) > most:
                print(f"  … the last {most} of {len(requests)}; all: homebot journal {_quote(device)}")
            if not response.is_so and was_obeyed(requests[-1]):
                print(f"\nIt changed after that: `homebot why {_quote(device)}` tells why.")
        elif not response.is_so:
            print(_unasked(device, options, response, now))
        if not response.is_so:
            _print_lines(_told_by_features("adds_to_why_not", door, device.id))
    return 0


def _unasked(device: Device, options: argparse.Namespace, response: ExplainMissingStateResponse, now: float) -> str:
    """Return why *device* is not in the wanted state if the journal has no command for it."""
    if response.problem:
        return printable(response.problem)
    begins = response.begins
    since = f" since the journal began, {ago_text(begins, now)}" if begins.sec else ""
    empty = "" if begins.sec else ": the journal is empty"
    how = f" To ask for it: homebot do {_quote(device)} {printable(response.word)}" if response.word else ""
    return f"Nobody asked for {_wanted(options)}{since}{empty}.{how}"


def _print_state(device: Device) -> None:
    state = state_text(device)
    end = "" if state.endswith("…") else "."
    reports = "reports events, and no state" if device.events else "does not report its state"
    print_line(f"{_name(device)} is {state}{end}" if state else f"{_name(device)} {reports}.", "bold")


def _name(device: Device) -> str:
    return printable(device.name or device.id)


def _quote(device: Device) -> str:
    return shlex.quote(_name(device))


def _wanted(options: argparse.Namespace) -> str:
    return printable(options.state, 40)


def _row(chain: Chain, client: JournalClient, now: float) -> tuple[str, ...]:
    cause = trigger_text(chain[0].trigger, client.names)
    part = client.names.get(f"{chain[0].device}#{chain[0].part}", "")
    result = (f"{printable(part, 60)}: " if part else "") + result_text(chain, now)
    result += f" (asked because {cause})" if cause else ""
    return clock_text(chain[0].at, now), issuer_text(chain[0].issuer), result
