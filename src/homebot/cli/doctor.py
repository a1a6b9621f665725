"""The arguments of ``homebot doctor``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot doctor
  homebot doctor --counts

It ends with 1 where something is not as it should be.
"""


def add_parser(commands: Commands) -> None:
    """Add ``doctor``."""
    parser = add_command(
        commands,
        "doctor",
        "tell what is wrong: crashes, failures, gateways, who breaks the rules, disputes, silent devices, the index",
        _EXAMPLES,
        "homebot.cli.commands.doctor:doctor",
    )
    parser.add_argument("--counts", action="store_true", help="show everything that was counted, not only faults")
