"""The arguments of ``homebot config``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_noun, add_plain_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot config check                            check homebot.toml
  homebot config check --config villa.toml        check another file
"""


def add_parser(commands: Commands) -> None:
    """Add ``config`` to *commands*."""
    verbs = add_noun(commands, "config", "check the configuration", _EXAMPLES)
    check = add_plain_command(
        verbs,
        "check",
        "check a configuration file without running it: keys, values, plug-ins and credentials",
        _EXAMPLES,
        "homebot.cli.commands.config:check",
    )
    check.add_argument("--config", metavar="FILE", default="homebot.toml", help="the file (default: homebot.toml)")
