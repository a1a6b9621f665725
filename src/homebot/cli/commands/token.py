"""``homebot token new``."""

import argparse
import json
import secrets
from pathlib import Path

from homebot.bridges.rosbridge.settings import check_token_name
from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, set_command
from homebot.cli.commands.run import with_environment
from homebot.config import parse_config
from homebot.errors import ConfigError, UsageError
from homebot.runtime.plan import make_plan
from homebot.support.toml_file import parse_toml

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot token new rosie --scope read --scope 'act: harmless' --scope 'robot: rosie'
  homebot token new wall_panel --scope read

The token is written to the file NAME.token next to the configuration, which only you can read, and the table
[door.tokens.NAME] is appended to the configuration; without a configuration, the table is printed. A running homebot
reads it at SIGHUP (`systemctl [--user] reload homebot`), without a restart.
"""
_SENDING = """\
A client sends the token, the only line of that file, in one of two ways:
  the header   Authorization: Bearer TOKEN
  the address  ws://HOST:PORT/?token=TOKEN    for clients that cannot set headers, such as browsers and Foxglove"""


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
        help="one right: read, 'act: QUERY', 'act: harmless', 'act: all', manage, raw or 'robot: NAME'; repeatable",
    )
    new.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")


def _new(options: argparse.Namespace) -> int:
    config = Path(options.config)
    check_token_name(options.name)
    token_file = config.parent / f"{options.name}.token"
    rights = ", ".join(map(json.dumps, options.scope))
    table = f"[door.tokens.{options.name}]\ntoken_file = {json.dumps(token_file.name)}\nscope = [{rights}]\n"
    try:
        before = config.read_text(encoding="utf-8-sig") if config.exists() else ""
    except (OSError, UnicodeDecodeError) as exc:
        raise UsageError(f"{config} cannot be read: {exc}") from exc
    if table.partition("\n")[0] in before:
        raise UsageError(f"{config} has a table [door.tokens.{options.name}]; choose another name, or remove it first")
    try:
        token_file.touch(0o600, exist_ok=False)
    except OSError as exc:
        hint = "; choose another name" if isinstance(exc, FileExistsError) else ""
        raise UsageError(f"{token_file} cannot be written: {exc.strerror}{hint}") from exc
    try:
        token_file.write_text(f"{secrets.token_urlsafe(32)}\n", encoding="ascii")
        tables = parse_toml(f"{before}\n{table}", str(config))
        make_plan(with_environment(parse_config(tables, str(config), config.parent)))
        if config.exists():
            with config.open("a", encoding="utf-8") as file:
                file.write(f"\n{table}")
    except (ConfigError, OSError) as exc:
        token_file.unlink()
        raise UsageError(f"{exc}; no token was created") from exc
    print(f"the token is in {token_file}, which only you can read")
    print(
        f"{config} has its table now; `systemctl [--user] reload homebot`, or `kill -HUP`, makes homebot read it"
        if config.exists()
        else f"add to homebot.toml:\n\n{table}"
    )
    print(_SENDING)
    return 0
