"""``homebot home``: which data belong to the home."""

import argparse
from pathlib import Path

from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, set_command
from homebot.cli.commands.run import with_environment
from homebot.config import load_config
from homebot.log import configure_logging
from homebot.runtime.home_folder import adopt_folder

_EXAMPLES = """\
  homebot home adopt homes/5f3c09a1d2e4b687      take these data; `homebot doctor` lists those not in use

homebot must not be running. The data that the home had stay in their folder. A folder is relative to HOMEBOT_DATA.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    adopt = add_verb(add_verbs(parser, _EXAMPLES), "adopt", "have the home take the data in a folder")
    adopt.add_argument("folder", metavar="FOLDER", help="the folder")
    adopt.add_argument("--config", metavar="FILE", type=Path, default=DEFAULT_CONFIG, help="(default: homebot.toml)")
    set_command(adopt, _adopt, _EXAMPLES)


def _adopt(options: argparse.Namespace) -> int:
    configure_logging()
    config = with_environment(load_config(options.config))
    print(f"the data of {config.home.name} are now those in {adopt_folder(config, options.config, options.folder)}")
    return 0
