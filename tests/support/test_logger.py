"""Lines of a homebot that is a library in somebody's program, who has not configured any logging."""

import subprocess
import sys

import pytest
import structlog

from homebot.support.logger import get_logger, observed_lines

pytestmark = pytest.mark.slow

PROGRAM = """\
import asyncio, structlog, sys
from homebot import Graph, Node, Runtime, configure_logging, parse_config
from homebot.messages import Log, String

async def house(*, warns=False):
    tables = {"gateways": {"mqtt": {"root": "home425"}}, "door": {"port": 0}, "apps": {"light_service": {}}}
    async with Runtime(parse_config(tables, "test")) as runtime, Node(runtime.graph, "mine") as node:
        lines = node.create_subscription(Log, "/rosout", qos_profile=100)
        node.log.debug("mine.debug")
        node.log.info("mine.info")
        if warns:
            node.log.warning("mine.warning", message="the lamp\\x1b[2J is hot", watts=9)
        return [line.msg for line in iter(lines.take, None)]

async def error():
    async with Node(Graph(), "mine") as node:
        def fail(message): raise RuntimeError("broken")
        done = asyncio.Event()
        node.create_subscription(String, "t", fail)
        node.create_subscription(String, "t", lambda message: done.set())
        node.create_publisher(String, "t").publish(String(data="x"))
        await done.wait()

def next_part():
    for stream in sys.stdout, sys.stderr:
        print("----", file=stream, flush=True)

print(asyncio.run(house())); structlog.get_logger().info("own"); print(structlog.is_configured())
next_part()
asyncio.run(house(warns=True))
next_part()
asyncio.run(error())
next_part()
configure_logging(level="info"); asyncio.run(house())
"""


def printed(program: str) -> tuple[str, str]:
    """Return what *program* prints, to standard output and to standard error."""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True)
    return done.stdout, done.stderr


@pytest.fixture(scope="module")
def parts() -> list[tuple[str, str]]:
    """What each part of the program prints, to standard output and to standard error."""
    out, err = printed(PROGRAM)
    return list(zip(out.split("----\n"), err.split("----\n"), strict=True))


def test_rosout_has_the_lines_below_a_warning_and_only_the_programs_own_are_printed(
    parts: list[tuple[str, str]],
) -> None:
    """Neither lines of a house that starts and stops, nor of a node of one's own; the program uses structlog's own."""
    out, err = parts[0]
    lines, own, is_configured = out.splitlines()
    assert (lines, err) == ("['mine.debug', 'mine.info']", "")
    assert "own" in own
    assert is_configured == "False"


def test_a_warning_is_printed_in_plain_words(parts: list[tuple[str, str]]) -> None:
    """As by ``homebot run``: time, node, words, nothing that steers the terminal."""
    out, err = parts[1]
    assert out == ""
    assert err[8:] == r"  mine           warning: the lamp\x1b[2J is hot" + "\n"


def test_an_error_comes_with_its_traceback_set_in(parts: list[tuple[str, str]]) -> None:
    out, err = parts[2]
    first, *rest = err.splitlines()
    assert out == ""
    assert "mine           error: " in first
    assert rest[0] == "  Traceback (most recent call last):"
    assert rest[-1] == "  RuntimeError: broken"


def test_configure_logging_counts_as_well(parts: list[tuple[str, str]]) -> None:
    out, err = parts[3]
    assert out == ""
    assert "running the app light_service" in err


CONFIGURED = "import structlog; structlog.configure(processors=[lambda *line: 'mine: ' + line[2]['event']])\n"
MADE = "import asyncio; from homebot import Graph, Node\nasync def made(): return Node(Graph(), 'mine')\n"
NODE = f"{MADE}node = asyncio.run(made())\n"


@pytest.mark.parametrize("code", [CONFIGURED + NODE, NODE + CONFIGURED], ids=["before homebot", "after homebot"])
def test_a_configuration_of_the_programs_own_counts(code: str) -> None:
    """Also for loggers that are there already."""
    assert printed(f"{code}node.log.info('hello')") == ("mine: hello\n", "")


def test_observers_see_lines_only_during_their_block() -> None:
    seen: list[str] = []

    def observer(_logger: object, _method: str, event: structlog.typing.EventDict) -> structlog.typing.EventDict:
        seen.append(event["event"])
        return event

    structlog.reset_defaults()
    log = get_logger(node="/mine")
    with observed_lines(observer):
        log.debug("first")
    log.debug("second")
    assert seen == ["first"]
    assert not structlog.is_configured()
