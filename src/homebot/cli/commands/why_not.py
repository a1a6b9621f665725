"""``homebot why-not``."""

from __future__ import annotations

import argparse

from homebot.cli.arguments import set_client_command
from homebot.cli.device_history import Chain, DeviceHistory
from homebot.cli.device_json import json_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.history_words import result_text
from homebot.cli.journal_client import JournalClient, chain_json
from homebot.cli.journal_words import ago_text, clock_text, issuer_text, trigger_text
from homebot.cli.table import printable
from homebot.cli.terminal import print_line, print_rows
from homebot.cli.time_format import to_seconds
from homebot.cli.values import state_text

__all__ = ["add_arguments"]

_MOST = 10

_EXAMPLES = """\
  homebot why-not 'Hall lamp' on
  homebot why-not 'Front door' locked --json

Tells which commands asked a device for a state, and what became of each; or that nobody asked for it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot why-not``."""
    set_client_command(parser, _why_not, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("state", metavar="STATE", help="the state it is not in: on, off, open, locked, 40, cleaning, …")
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


def _why_not(options: argparse.Namespace) -> int:
    """Print which commands asked for a state, and what became of them."""

    def run(door: DoorClient) -> int:
        device = named_device(door, options.device)
        client = JournalClient(door)
        client.names[device["id"]] = device["name"]
        history = DeviceHistory(client)
        asked = history.asked(device, options.state)
        if options.json:
            chains = [chain_json(one.entries, client.names) for one in asked]
            found = {"device": device["id"], "state": state_text(device), "wanted": options.state, "asked": chains}
            print(json_text(found))
            return 0
        now = house_time(door)
        name, wanted = printable(device["name"] or device["id"]), printable(options.state, 40)
        print_line(f"{name} is {state_text(device) or 'silent about its state'}.", "bold")
        if asked:
            times = "once" if len(asked) == 1 else f"{len(asked)} times"
            print(f"{wanted} was asked for {times}:")
            print()
            print_rows([_row(one, client, now) for one in asked[-_MOST:]])
            if len(asked) > _MOST:
                print(f"  … the last {_MOST} of {len(asked)}; all: homebot journal --device '{name}'")
        elif history.begins["sec"]:
            print(f"Nobody asked for {wanted} since the journal began, {ago_text(to_seconds(history.begins), now)}.")
        else:
            print(f"Nobody asked for {wanted}: the journal is empty.")
        return 0

    return with_client(options, run)


def _row(chain: Chain, client: JournalClient, now: float) -> tuple[str, ...]:
    cause = trigger_text(chain.trigger, client.names)
    result = result_text(chain) + (f" (asked because {cause})" if cause else "")
    return clock_text(chain.first["at"], now), issuer_text(chain.first["issuer"]), result
