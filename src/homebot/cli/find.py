"""The arguments of ``homebot find``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command, whole

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot find 'light and dimmable in kitchen'
  homebot find on lights
  homebot find --why window
  homebot find 'sensor with temperature not stale'

A query combines types (light, lamp, window, …), capabilities (dimmable, temperature > 21), states (on, open, locked),
`in AREA`, problems (stale, unreachable, disputed), settings (category=config) and words of names and models, with
`and`, `or`, `not` and parentheses.
"""


def add_parser(commands: Commands) -> None:
    """Add ``find``."""
    parser = add_command(
        commands,
        "find",
        "find devices by type, capability, state, area or name",
        _EXAMPLES,
        "homebot.cli.commands.find:find",
    )
    parser.add_argument("query", metavar="QUERY", nargs="+", help="words to search for")
    parser.add_argument("--why", action="store_true", help="show why each device matches and ranks where it does")
    parser.add_argument("--limit", metavar="N", type=whole, default=50, help="show the best N (default: 50)")
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")
