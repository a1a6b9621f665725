"""The arguments of ``homebot node``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command, add_noun

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot node list
  homebot node info /rosapi
"""


def add_parser(commands: Commands) -> None:
    """Add ``node`` and its commands."""
    verbs = add_noun(commands, "node", "list and inspect nodes", _EXAMPLES)
    parser = add_command(
        verbs, "list", "list every node", "  homebot node list\n", "homebot.cli.commands.node:list_nodes"
    )
    parser.add_argument("-a", "--all", action="store_true", help="show hidden nodes too")
    examples = "  homebot node info /rosapi\n"
    parser = add_command(
        verbs,
        "info",
        "show what a node publishes, subscribes to and serves",
        examples,
        "homebot.cli.commands.node:info",
    )
    parser.add_argument("node", metavar="NODE", help="full name of the node")
