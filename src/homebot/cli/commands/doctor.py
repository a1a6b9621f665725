"""``homebot doctor``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import DEFAULT_CONFIG, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import LinkError, UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.bridges.rosapi.doctor import ExamineResponse
    from homebot.devices.findings import Finding

_MAX_WAIT_S = 60.0
"""Seconds to wait for the answer, which is as slow as the slowest component."""

_MAX_REASON = 1000
"""The limit of characters of a reason, which may contain a remedy of several sentences."""

_EXAMPLES = """\
  homebot doctor
  homebot doctor --json
  homebot doctor --offline --reach     before the start: configuration, files, ports, logins

The exit status is 1 if there are problems, or no homebot. Each line begins with a code; docs/operate.md lists them.
Some of the counters: `strays` are reports that came before the announcement of their device; `holds`, waits of
publishers for a slow client of the embedded broker; `unread given up`, connections that it closed because a packet
stayed incomplete; `answers late`, answers of services whose callers had given up; `asks dropped`, requests for a
device's state, and `expiries dropped`, values that expire (such as motion), beyond the limit that can be tracked.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _doctor, _EXAMPLES)
    parser.add_argument("--gateways", action="store_true", help="only check that it runs and its gateways work")
    parser.add_argument("--counts", action="store_true", help="show all counters, not only those of problems")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--offline", action="store_true", help="check what a start needs; no running homebot is required"
    )
    parser.add_argument("--config", metavar="FILE", help="with --offline: the configuration (default: homebot.toml)")
    parser.add_argument("--reach", action="store_true", help="with --offline: also log in to brokers and hubs")


def _doctor(options: argparse.Namespace) -> int:
    if options.offline:
        from homebot.cli.commands.config import offline_findings  # noqa: PLC0415 - loads the plug-ins

        file = Path(options.config or DEFAULT_CONFIG)
        findings = [finding.model_dump(mode="json") for finding in offline_findings(file, reaches=options.reach)]
        return _show(f"checked {file} and what it needs", {"config": str(file)}, findings, options)
    if options.config or options.reach:
        raise UsageError("--config and --reach are for --offline; a running homebot knows its configuration")
    try:
        return with_client(options, _ask)
    except LinkError as exc:
        raise LinkError(f"{exc}; `homebot doctor --offline` checks what it needs") from exc


def _ask(door: DoorClient, options: argparse.Namespace) -> int:
    asked = {"counts": options.counts, "gateways_only": options.gateways}
    fields = door.call("/rosapi/doctor", asked, timeout=_MAX_WAIT_S)
    response = cast("ExamineResponse", JsonMessage(fields))
    texts = [f"home {printable(door.home)} on {door.where}"]
    texts += [] if response.gateways else ["no gateway runs; one with a table such as [gateways.mqtt] finds devices"]
    texts += [gateway.text for gateway in response.gateways if gateway.state == "active"]
    texts.append(f"devices: {response.devices}, unconfirmed: {response.unconfirmed}")
    states = {gateway.name: gateway.state for gateway in response.gateways}
    counts = {"devices": response.devices, "unconfirmed": response.unconfirmed}
    facts = {"home": door.home, "door": door.where, "gateways": states, **counts}
    return _show("\n".join(texts), facts, cast("list[dict[str, object]]", fields["findings"]), options)


def _show(
    title: str, facts: Mapping[str, object], findings: Sequence[Mapping[str, object]], options: argparse.Namespace
) -> int:
    is_well = not any(finding["is_problem"] for finding in findings)
    if options.json:
        print(json.dumps({**facts, "is_well": is_well, "findings": findings}, indent=2))
        return 0 if is_well else 1
    print(title)
    for finding in findings:
        print_finding(cast("Finding", JsonMessage(finding)))
    print()
    print_line("all is well" if is_well else "problems found, the worst above", "bold green" if is_well else "bold red")
    return 0 if is_well else 1


def print_finding(finding: Finding) -> None:
    """Print *finding* and its next step."""
    code, title = finding.code, finding.title
    for row in finding.rows:
        if not row.what:
            why = printable(row.why, _MAX_REASON)
            print(f"{code} {title}: {why}" if title else f"{code} {why}")
    print_rows([(row.what, row.why) for row in finding.rows if row.what], f"{code} {title}:")
    if finding.total > len(finding.rows):
        print(f"  … the first {len(finding.rows)} of {finding.total} are shown{finding.hint}")
    if finding.next:
        print(f"  → {finding.next}")
