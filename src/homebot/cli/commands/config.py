"""``homebot config check``."""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from homebot.cli.arguments import add_verb, add_verbs, set_command
from homebot.cli.commands.run import config_errors, with_environment
from homebot.config import load_config, load_tables
from homebot.gateways import Gateway
from homebot.log import configure_logging
from homebot.runtime.plan import Plan, PlannedComponent, make_plan

__all__ = ["add_arguments", "plan_of"]

_EXAMPLES = """\
  homebot config check                            check homebot.toml
  homebot config check --config villa.toml        check another file
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    check = add_verb(verbs, "check", "check a configuration file: keys, values, plug-ins and credentials")
    check.add_argument("--config", metavar="FILE", default="homebot.toml", help="the file (default: homebot.toml)")
    set_command(check, _check, _EXAMPLES)


def _check(options: argparse.Namespace) -> int:
    configure_logging()
    path = Path(options.config)
    if errors := config_errors(load_tables(path), path):
        for error in errors:
            print(f"homebot: {error}", file=sys.stderr)
        return 1
    plan = plan_of(path)
    print(f"{path} is valid: home {plan.home}")
    print(f"  gateways:  {_list(map(_gateway_text, plan.gateways))}")
    print(f"  apps:      {_list(app.name for app in plan.apps)}")
    print(f"  rosbridge: {plan.door.host}:{plan.door.port}{' (token required)' if plan.door.token else ''}")
    if plan.thing_directory is not None:
        things = plan.thing_directory
        print(f"  things:    {things.host}:{things.port}{' (token required)' if things.token else ''}")
    return 0


def plan_of(path: Path) -> Plan:
    """Return the plan of a run with the configuration *path*.

    Raises:
        ConfigError: The configuration is invalid.
    """
    return make_plan(with_environment(load_config(path)))


def _gateway_text(gateway: PlannedComponent[Gateway]) -> str:
    return f"{gateway.name} (observing only)" if gateway.kind.observes(gateway.settings) else gateway.name


def _list(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
