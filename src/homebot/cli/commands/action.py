"""``homebot action list``."""

import argparse

from homebot.cli.arguments import add_verbs
from homebot.cli.graph_queries import add_list


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_list(add_verbs(parser, "  homebot action list -t\n"), "action", "action server")
