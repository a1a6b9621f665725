"""``homebot token new`` and ``homebot token list``."""

from __future__ import annotations

import argparse
import json
import secrets
import time
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from homebot.bridges.rosbridge.settings import check_token_name
from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, set_command
from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.secret_tables import add_secret_table
from homebot.cli.terminal import print_table
from homebot.devices.names import LIST_TOKENS
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import ago, iso, to_seconds
from homebot.errors import UsageError

if TYPE_CHECKING:
    from homebot.devices.access_messages import ListedToken, ListTokensResponse
    from homebot.runtime.plan import Plan

_EXAMPLES = """\
  homebot token new rosie --scope read --scope 'act: harmless' --scope 'robot: rosie'
  homebot token new wall_panel --scope read
  homebot token new guest --scope 'act: light in hall' --until 2026-12-31

The token is written to the file NAME.token next to the configuration, which only you can read, and the table
[door.tokens.NAME] is appended to the configuration; without a configuration, the table is printed. A running homebot
reads it at SIGHUP (`systemctl [--user] reload homebot`), without a restart.
"""
_SENDING = """\
A client sends the token, the only line of that file, in one of two ways:
  the header   Authorization: Bearer TOKEN
  the address  ws://HOST:PORT/?token=TOKEN    for WebSockets of clients that cannot set headers, such as Foxglove"""
_LISTED = """\
  homebot token list

The tokens of a running homebot, without their secrets: rights, end, and when a client last showed it. The last uses are
known since the start of homebot, and those of a token that is connected are `now`. It needs the right `manage`.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    new = add_verb(verbs, "new", "create a token for one program, with the rights that it needs")
    set_command(new, _new, _EXAMPLES)
    new.add_argument("name", metavar="NAME", help="the program: letters, digits, - and _")
    new.add_argument(
        "--scope",
        metavar="RIGHT",
        action="append",
        required=True,
        help="one right: read, 'act: QUERY', 'act: harmless', 'act: all', 'ask: QUERY', manage, raw or 'robot: NAME'; "
        "repeatable",
    )
    new.add_argument("--until", metavar="DATE", default="", help="its end: 2026-12-31, or '2026-12-31 18:00'")
    new.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")
    listed = add_verb(verbs, "list", "list the tokens, and when each was last used")
    set_door_command(listed, _list, _LISTED)
    listed.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def _new(options: argparse.Namespace) -> int:
    config = Path(options.config)
    table, token_file, _ = add_token(config, options.name, options.scope, options.until)
    print(f"the token is in {token_file}, which only you can read")
    print(
        f"{config} has its table now; `systemctl [--user] reload homebot`, or `kill -HUP`, makes homebot read it"
        if config.exists()
        else f"add to homebot.toml:\n\n{table}"
    )
    print(_SENDING)
    return 0


def add_token(config: Path, name: str, rights: Iterable[str], until: str = "") -> tuple[str, Path, str]:
    """Write a token with *rights* to its file, and its table to *config*; return table, file and secret.

    Raises:
        UsageError: As :func:`homebot.cli.secret_tables.add_secret_table`, or its name cannot be one.
    """
    check_token_name(name)
    token_file = config.parent / f"{name}.token"
    scope = ", ".join(map(json.dumps, rights))
    table = f"[door.tokens.{name}]\ntoken_file = {json.dumps(token_file.name)}\nscope = [{scope}]\n"
    table += f"until = {json.dumps(until)}\n" if until else ""
    secret = secrets.token_urlsafe(32)
    add_secret_table(config, table, token_file, secret, partial(_check_end, name), creates=False)
    return table, token_file, secret


def _check_end(name: str, plan: Plan) -> None:
    if plan.door.tokens[name].until <= time.time():
        raise UsageError("its end (--until) is over")


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    response = cast("ListTokensResponse", JsonMessage(door.call(LIST_TOKENS)))
    if options.json:
        print(list_text([json_text(_json(token)) for token in response.tokens]))
        return 0
    now, unused = house_time(door), f"not since {_moment(to_seconds(response.since))}, the start of homebot"
    rows = [
        (
            token.name,
            ", ".join(token.scope) or "every right",
            f"{_moment(token.until)}{' (over)' * (token.until <= now)}" if token.until else "",
            "now" if token.is_connected else ago(token.used_at, now) if token.used_at.sec else unused,
        )
        for token in response.tokens
    ]
    if rows:
        print_table(("TOKEN", "RIGHTS", "UNTIL", "LAST USED"), rows, if_any=("UNTIL",))
    else:
        print("there are no tokens; `homebot token new` makes one")
    return 0


def _moment(seconds: float) -> str:
    return f"{datetime.fromtimestamp(seconds).astimezone():%Y-%m-%d %H:%M}"


def _json(token: ListedToken) -> dict[str, object]:
    return {
        "token": token.name,
        "rights": list(token.scope),
        "until": datetime.fromtimestamp(token.until, UTC).isoformat() if token.until else None,
        "used_at": iso(token.used_at) if token.used_at.sec else None,
        "connected": token.is_connected,
    }
