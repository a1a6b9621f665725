"""The arguments of ``homebot service``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command, add_noun, message, positive, type_or_message

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot service list -t
  homebot service call /rosapi/get_time
"""


def add_parser(commands: Commands) -> None:
    """Add ``service`` and its commands."""
    verbs = add_noun(commands, "service", "list and call services", _EXAMPLES)
    examples = "  homebot service list\n  homebot service list -t\n"
    parser = add_command(verbs, "list", "list every service", examples, "homebot.cli.commands.service:list_services")
    parser.add_argument("-t", "--show-types", action="store_true", help="show each service's type")
    parser.add_argument("-a", "--all", action="store_true", help="show hidden services too")
    examples = (
        "  homebot service call /rosapi/get_time\n"
        "  homebot service call /getIndexData '{service_type: lights}'\n"
        '  homebot service call /rosapi/topic_type rosapi_msgs/srv/TopicType \'{"topic": "/rosout"}\'\n'
    )
    parser = add_command(
        verbs, "call", "call a service and print its answer", examples, "homebot.cli.commands.service:call"
    )
    parser.add_argument("service", metavar="SERVICE", help="name of the service")
    parser.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="type that it should have"
    )
    parser.add_argument(
        "request", metavar="REQUEST", nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )
    parser.add_argument("--timeout", metavar="S", type=positive, default=5.0, help="seconds to wait (default: 5)")
    parser.add_argument("--json", action="store_true", help="print the answer as one line of JSON")
