"""``homebot join``: another machine, with gateways only, becomes part of the house."""

from __future__ import annotations

import argparse
import base64
import getpass
import json
import re
import secrets
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from homebot.cli.arguments import DEFAULT_CONFIG, set_command
from homebot.cli.commands.config import plan_of
from homebot.cli.secret_tables import add_secret_table, text_of
from homebot.errors import UsageError
from homebot.names import validate_node_name
from homebot.support.toml_file import parse_toml

if TYPE_CHECKING:
    from homebot.runtime.plan import Plan

_EXAMPLES = """\
  homebot join --new attic                    on the first machine: print a code for the machine attic
  homebot join tls/villa.lan:7447             on the machine attic: ask for that code, and write its configuration
  homebot join tls/villa.lan:7447 < code      likewise, from a file

The first machine keeps the index, the control and the journal, and listens: see `listen` of [ros]. Both get the same
secret, in a file that only you can read. ADDRESS is where the first one listens, as the other one sees it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _join, _EXAMPLES)
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("address", metavar="ADDRESS", nargs="?", help="the address of the first machine")
    which.add_argument("--new", metavar="NAME", help="on the first machine: the name of the one that is to join")
    parser.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")


class _Code(BaseModel):
    """All that a machine needs to join.

    Attributes:
        secret: The secret of both machines.
        certificate: The certificate of the first one, in PEM; empty if it listens without.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", hide_input_in_errors=True)

    home: str
    machine: str
    secret: str = Field(repr=False)
    certificate: str = ""

    @property
    def text(self) -> str:
        return base64.urlsafe_b64encode(self.model_dump_json().encode()).decode()

    @classmethod
    def of_text(cls, text: str) -> Self:
        try:
            return cls.model_validate_json(base64.urlsafe_b64decode(text.strip().encode()))
        except (ValueError, ValidationError):
            raise UsageError("that is not the code which `homebot join --new NAME` printed; copy all of it") from None


def _join(options: argparse.Namespace) -> int:
    config = Path(options.config)
    if options.new is not None:
        _invite(config, validate_node_name(options.new))
    else:
        code = getpass.getpass("code: ") if sys.stdin.isatty() else sys.stdin.readline()
        _accept(config, options.address, _Code.of_text(code))
    return 0


def _invite(config: Path, machine: str) -> None:
    plan = plan_of(config)
    if plan.link is None or not plan.link.listen:
        raise UsageError(
            f"{config} has no listen in [ros], where {machine} could connect; make a certificate and see what it "
            "prints: homebot router --certificate"
        )
    token_file = config.parent / f"{machine}.token"
    table = f'[gateways.{machine}]\nclass = "homebot"\ntoken_file = {json.dumps(token_file.name)}\n'
    secret = secrets.token_urlsafe(32)
    add_secret_table(config, table, token_file, secret, lambda _: None, creates=False)
    text = "" if plan.link.cert_file is None else plan.link.cert_file.read_text(encoding="ascii")
    code = _Code(
        home=plan.home,
        machine=machine,
        secret=secret,
        certificate="".join(re.findall(r"-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----\n?", text, re.DOTALL)),
    )
    print(f"{config} has the gateway {machine} now; restart homebot. On {machine}, run")
    print(f"\n  homebot join {plan.link.listen}\n\nwith the address of this computer, and enter this secret code:")
    print(f"\n{code.text}\n")


def _accept(config: Path, address: str, code: _Code) -> None:
    home = parse_toml(text_of(config), str(config)).get("home", {})
    token_file, ca_file = (config.parent / f"{code.machine}.{kind}" for kind in ("token", "crt"))
    table = f"[ros]\nconnect = [{json.dumps(address)}]\nmachine = {json.dumps(code.machine)}\n"
    table += f"password_file = {json.dumps(token_file.name)}\n"
    if code.certificate:
        table += f"ca = {json.dumps(ca_file.name)}\n"
    table += "" if home else f"\n[home]\nname = {json.dumps(code.home)}\n"

    def check(plan: Plan) -> None:
        if plan.home != code.home:
            raise UsageError(f"{config}: the home is {plan.home}, and not {code.home}; change name in [home]")

    add_secret_table(config, table, token_file, code.secret, check, creates=True)
    if code.certificate:
        ca_file.write_text(code.certificate, encoding="ascii")
    print(f"{config} joins {code.home} as {code.machine} now, with the secret in {token_file}, which only you can read")
    print("add its gateways there, such as [gateways.mqtt], if it has none yet, and run: homebot run")
