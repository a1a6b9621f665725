"""Log lines: how they look, and the limit for lines that outsiders can cause."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator

import pytest
import structlog

from homebot.clock import ManualClock
from homebot.errors import UsageError
from homebot.log import LogFormat, LogLimit, configure_logging, sentence


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _default_logging_again() -> Iterator[None]:
    yield
    structlog.reset_defaults()


def logged(log_format: LogFormat, out: io.StringIO, **facts: object) -> str:
    configure_logging(log_format, stream=out)
    structlog.get_logger(node="/gateway/mqtt").info("mqtt.link_lost", **facts)
    return out.getvalue()


def test_a_line_for_people_has_time_node_and_words() -> None:
    line = logged("console", io.StringIO(), message="The broker is gone.")
    assert line[2] == line[5] == ":"
    assert line[8:] == "  gateway/mqtt   The broker is gone.\n"


def test_a_line_without_words_shows_its_event_and_facts() -> None:
    assert logged("console", io.StringIO(), url="mqtt://x", attempts=3).endswith(
        "mqtt.link_lost  url=mqtt://x  attempts=3\n"
    )


def test_a_line_for_programs_is_one_json_object() -> None:
    line = json.loads(logged("json", io.StringIO(), attempts=3))
    assert line.pop("timestamp").endswith("Z")
    assert line == {"event": "mqtt.link_lost", "node": "/gateway/mqtt", "level": "info", "attempts": 3}


def test_an_outsider_cannot_break_the_line_or_steer_the_terminal() -> None:
    line = logged("console", Terminal(), message="on\n12:00:00 fake\x1b[2J\x07 Küche")
    assert line.endswith(r"on\n12:00:00 fake\x1b[2J\x07 Küche" + "\n")


@pytest.mark.parametrize(("stream", "coloured"), [(io.StringIO, False), (Terminal, True)])
def test_only_a_terminal_gets_colours(stream: type[io.StringIO], *, coloured: bool) -> None:
    out = stream()
    configure_logging(stream=out)
    structlog.get_logger().warning("a.b")
    assert ("\x1b[33m" in out.getvalue()) is coloured
    assert "warning: a.b" in out.getvalue()


def test_an_exception_is_shown_below_its_line() -> None:
    out = io.StringIO()
    configure_logging(stream=out)
    try:
        int("boom")
    except ValueError:
        structlog.get_logger().exception("node.crashed")
    first, *rest = out.getvalue().splitlines()
    assert first.endswith("error: node.crashed")
    assert rest[-1] == "ValueError: invalid literal for int() with base 10: 'boom'"


def test_lines_below_the_level_are_not_shown() -> None:
    out = io.StringIO()
    configure_logging(stream=out, level="warning")
    structlog.get_logger().info("a.b")
    assert out.getvalue() == ""


def test_an_unknown_level_is_refused() -> None:
    with pytest.raises(UsageError, match="no log level 'loud'; there are debug, info, warning, error, critical"):
        configure_logging(level="loud")


def test_further_processors_see_each_line() -> None:
    seen: list[str] = []

    def see(_logger: object, _method: str, event: structlog.typing.EventDict) -> structlog.typing.EventDict:
        seen.append(sentence(event))
        return event

    configure_logging(stream=io.StringIO(), processors=[see])
    structlog.get_logger().info("a.b", x=1)
    assert seen == ["a.b  x=1"]


def test_one_line_of_a_kind_per_interval_gets_through_and_tells_how_many_did_not() -> None:
    clock = ManualClock()
    limit = LogLimit(clock, interval=10.0)
    assert [limit.allows("bad_topic") for _ in range(3)] == [0, None, None]
    assert limit.allows("bad_payload") == 0
    clock.advance(10.0)
    assert limit.allows("bad_topic") == 2
    clock.advance(10.0)
    assert limit.allows("bad_topic") == 0


def test_a_kind_that_keeps_coming_is_not_forgotten_for_a_thousand_others() -> None:
    limit = LogLimit(ManualClock())
    limit.allows("flood")
    for number in range(1_500):
        limit.allows(f"kind {number}")
        assert limit.allows("flood") is None


def test_the_limit_remembers_a_thousand_kinds() -> None:
    limit = LogLimit(ManualClock())
    for number in range(1_001):
        limit.allows(f"kind {number}")
    assert limit.allows("kind 1000") is None
    assert limit.allows("kind 0") == 0


def test_a_burst_of_lines_passes_before_the_limit_holds_them_back() -> None:
    """And the next interval tells how many were held back."""
    clock = ManualClock()
    limit = LogLimit(clock, interval=10.0, burst=3)
    assert [limit.allows("kind") for _ in range(5)] == [0, 0, 0, None, None]
    clock.advance(10.0)
    assert [limit.allows("kind") for _ in range(4)] == [2, 0, 0, None]
