"""``homebot mcp``."""

import argparse
import signal
import sys
from contextlib import redirect_stdout

from homebot.cli.arguments import set_client_command
from homebot.cli.server_address import server_of
from homebot.plugins import check_extra

_EXAMPLES = """\
  homebot mcp --token-file agent.token

An agent's program starts this command and communicates with it in the Model Context Protocol over standard input and
output. The agent has the rights of the token; without one, those of a client without a token.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _serve, _EXAMPLES)


def _serve(options: argparse.Namespace) -> int:
    check_extra("homebot mcp", "mcp", "mcp")
    address = server_of(options)
    from homebot.bridges.home_api.agent_server import house_server  # noqa: PLC0415 - not before the extra is there
    from homebot.cli.mcp_server import ApiClient  # noqa: PLC0415 - as above

    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the SDK's thread that reads standard input cannot be cancelled
    with redirect_stdout(sys.__stdout__):  # the protocol writes bytes to it
        house_server(ApiClient(address)).run("stdio")
    return 0
