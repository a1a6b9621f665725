"""The arguments of ``homebot topic``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command, add_noun, message, positive, whole

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot topic list -t
  homebot topic echo /rosout
  homebot topic info -v /rosout
"""


def add_parser(commands: Commands) -> None:
    """Add ``topic`` and its commands."""
    verbs = add_noun(commands, "topic", "list, inspect, read and publish topics", _EXAMPLES)
    _add_list(verbs)
    _add_echo(verbs)
    _add_pub(verbs)
    _add_info(verbs)
    _add_hz(verbs)


def _add_list(verbs: Commands) -> None:
    examples = "  homebot topic list\n  homebot topic list -t\n"
    parser = add_command(verbs, "list", "list every topic", examples, "homebot.cli.commands.topic:list_topics")
    parser.add_argument("-t", "--show-types", action="store_true", help="show each topic's type")
    parser.add_argument("-a", "--all", action="store_true", help="show hidden topics too")


def _add_echo(verbs: Commands) -> None:
    examples = (
        "  homebot topic echo /rosout\n  homebot topic echo --once --field msg /rosout\n"
        "  homebot topic echo --json --timeout 10 /discovery/changes\n"
    )
    parser = add_command(verbs, "echo", "print the messages of a topic", examples, "homebot.cli.commands.echo:echo")
    parser.add_argument("topic", metavar="TOPIC", help="name of the topic, which need not exist yet")
    parser.add_argument("--once", action="store_true", help="end after the first message")
    parser.add_argument("--timeout", metavar="S", type=positive, help="give up after S seconds without a message")
    parser.add_argument("--field", metavar="A.B", help="print only this field")
    parser.add_argument("--json", action="store_true", help="print each message as one line of JSON")


def _add_pub(verbs: Commands) -> None:
    examples = (
        "  homebot topic pub --once /hello std_msgs/String '{data: hi}'\n"
        '  homebot topic pub -r 5 -t 10 /hello std_msgs/String \'{"data": "hi"}\'\n'
        "  homebot topic pub --once /gateway/mqtt/out '{address: home/lights/lamp1/in, payload: off}'\n"
    )
    parser = add_command(verbs, "pub", "publish on a topic", examples, "homebot.cli.commands.pub:pub")
    parser.add_argument("topic", metavar="TOPIC", help="name of the topic")
    parser.add_argument("type", metavar="TYPE", nargs="?", default="", help="type of the topic; needed for a new one")
    parser.add_argument("value", metavar="VALUE", type=message, help="the message, as JSON or as {field: value}")
    count = parser.add_mutually_exclusive_group()
    count.add_argument("-1", "--once", action="store_const", const=1, dest="times", help="publish once")
    count.add_argument("-t", "--times", metavar="N", type=whole, help="publish N times (default: until Ctrl-C)")
    parser.add_argument(
        "-r", "--rate", metavar="HZ", type=positive, default=1.0, help="messages per second (default: 1)"
    )


def _add_info(verbs: Commands) -> None:
    examples = "  homebot topic info /rosout\n  homebot topic info -v /rosout\n"
    parser = add_command(
        verbs, "info", "show the publishers and subscriptions of a topic", examples, "homebot.cli.commands.topic:info"
    )
    parser.add_argument("topic", metavar="TOPIC", help="name of the topic")
    parser.add_argument("-v", "--verbose", action="store_true", help="show each node with its QoS")


def _add_hz(verbs: Commands) -> None:
    examples = "  homebot topic hz /rosout\n  homebot topic hz -w 100 /rosout\n"
    parser = add_command(verbs, "hz", "measure the publishing rate of a topic", examples, "homebot.cli.commands.hz:hz")
    parser.add_argument("topic", metavar="TOPIC", help="name of the topic")
    parser.add_argument("-w", "--window", metavar="N", type=whole, default=10_000, help="messages to average over")
