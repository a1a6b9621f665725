"""``homebot app``."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from homebot.cli.arguments import Commands, add_verb, add_verbs, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.table import printable
from homebot.devices.names import LOAD_APP, RELOAD_APP, UNLOAD_APP
from homebot.errors import PeerError

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot app load hall.py        start an app in a file, in the homebot that runs
  homebot app reload hall         load its file and its settings anew; if that fails the old one runs on
  homebot app unload hall         stop it, until homebot is restarted or it is loaded again

It takes the right `manage`. What an app keeps in its store stays.
"""

_LONGEST = 60.0
"""Seconds: an app may take ten to stop and ten to start, twice where it is rolled back."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot app``."""
    verbs = add_verbs(parser, _EXAMPLES)
    _add(verbs, "load", LOAD_APP, "start an app of the configuration, an installed one, or one in a file")
    _add(verbs, "reload", RELOAD_APP, "replace an app by its code and settings as they are now")
    _add(verbs, "unload", UNLOAD_APP, "stop an app")


def _add(verbs: Commands, name: str, service: str, summary: str) -> None:
    parser = add_verb(verbs, name, summary)
    set_client_command(parser, partial(_change, service), _EXAMPLES)
    what = "its name, or FILE.py, or FILE.py:CLASS" if service == LOAD_APP else "its name"
    parser.add_argument("app", metavar="APP", help=what)


def _change(service: str, options: argparse.Namespace) -> int:
    """Ask for a change of an app, and print the answer."""

    def change(door: DoorClient) -> int:
        answer = door.call(service, {"app": _absolute(options.app)}, timeout=_LONGEST)
        if not answer["success"]:
            raise PeerError(printable(str(answer["message"]), 2000))
        print(printable(str(answer["message"]), 2000))
        return 0

    return with_client(options, change)


def _absolute(app: str) -> str:
    """Return *app* with the path of its file as the other program needs it."""
    file, colon, kind = app.partition(":")
    return f"{Path(file).resolve()}{colon}{kind}" if file.endswith(".py") else app
