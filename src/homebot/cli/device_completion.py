"""Names of devices for shell completion, from the running homebot."""

import argparse
import os
import shlex
import signal
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, Final, cast

from homebot.cli.arguments import add_server_options
from homebot.cli.door_client import open_door
from homebot.cli.server_address import server_of
from homebot.devices.names import LIST_DEVICES

COMPLETE_DEVICES: Final = "--complete-devices"
_LIMIT: Final = 0.3
"""Seconds that a person waits after pressing Tab."""

_MAX_NAMES: Final = 2000
_BASH: Final = f"""\
_homebot_devices() {{
  local name
  "${{COMP_WORDS[0]}}" {COMPLETE_DEVICES} "${{COMP_WORDS[@]:1:COMP_CWORD}}" 2>/dev/null | case $1 in
    \\"*) sed 's/[\\\\"$`]/\\\\&/g' ;;
    \\'*) sed "s/'/'\\\\\\\\''/g" ;;
    *) while IFS= read -r name; do printf '%q\\n' "$name"; done ;;
  esac
}}
"""
"""Names are escaped even inside quotation marks, because devices choose their names."""

_ZSH: Final = f"""\
_homebot_devices() {{
  local -a names
  names=(${{(f)"$(homebot {COMPLETE_DEVICES} "${{words[@]}}" "$PREFIX" 2>/dev/null)"}})
  compadd -M 'm:{{[:lower:][:upper:]}}={{[:upper:][:lower:]}}' -a names
}}
"""
DEVICE_NAMES: Final = {
    "bash": "_homebot_devices",
    "zsh": "_homebot_devices",
    "fish": f"(homebot {COMPLETE_DEVICES} (commandline -opc)[2..-1] (commandline -ct) 2>/dev/null)",
    "preamble": {"bash": _BASH, "zsh": _ZSH},
}
"""The command with which each shell gets device names, for shtab."""


def print_devices(words: Sequence[str]) -> int:
    """Print the names, or else the ids, of devices that begin with the last of *words*; give up after 0.3 s.

    Args:
        words: The command line after the program; it may select the homebot.
    """
    with suppress(Exception):  # completion cannot show errors
        signal.signal(signal.SIGALRM, lambda *_: os._exit(0))
        signal.setitimer(signal.ITIMER_REAL, _LIMIT)
        try:
            print(*_names(words), sep="\n")
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)  # the alarm would kill an exiting Python
    return 0


def _names(words: Sequence[str]) -> list[str]:
    parser = argparse.ArgumentParser(add_help=False, exit_on_error=False)
    add_server_options(parser)
    address = server_of(parser.parse_known_args(words[:-1])[0])
    begin = _unquote(words[-1])
    devices: list[dict[str, Any]] = []  # as they arrive
    with open_door(address) as door:
        while page := cast("list[dict[str, Any]]", door.call(LIST_DEVICES, {"offset": len(devices)})["devices"]):
            devices += page
            if len(devices) >= _MAX_NAMES:
                break
    names = [*dict.fromkeys(device["name"] for device in devices if str(device["name"]).isprintable())]
    fits = (
        [name for name in names if name.startswith(begin)],
        [name for name in names if name.casefold().startswith(begin.casefold())],
        [device["id"] for device in devices if device["id"].startswith(begin)],
    )
    return next(filter(None, fits), [])


def _unquote(word: str) -> str:
    """Return *word* as the shell reads it, even with an unclosed quotation mark."""
    for end in ("", "'", '"'):
        with suppress(ValueError):
            return next(iter(shlex.split(word + end)), "")
    return word
