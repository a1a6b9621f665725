"""The arguments of ``homebot doctor``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot doctor
  homebot doctor --counts

The exit status is 1 if there are problems.
"""


def add_parser(commands: Commands) -> None:
    """Add ``doctor``."""
    parser = add_command(
        commands,
        "doctor",
        "diagnose problems: crashes, failures, gateways, quarantined topics, disputes, silent devices, the index",
        _EXAMPLES,
        "homebot.cli.commands.doctor:doctor",
    )
    parser.add_argument("--counts", action="store_true", help="show all counters, not only those of faults")
