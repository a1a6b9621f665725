"""Log lines: how they look, and the limit for lines that outsiders can cause."""

import io
import json
import logging
import os
import re
import time
import warnings
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
import structlog
from hypothesis import given
from hypothesis import strategies as st

from homebot.clock import ManualClock
from homebot.errors import UsageError
from homebot.log import LogFormat, LogLimit, configure_logging, sentence


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _default_logging_again(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.delenv("NO_COLOR", raising=False)
    root = logging.getLogger()
    handlers = list(root.handlers)
    yield
    structlog.reset_defaults()
    root.handlers[:] = handlers
    logging.captureWarnings(capture=False)


def logged(log_format: LogFormat, out: io.StringIO, **facts: object) -> str:
    configure_logging(log_format, stream=out)
    structlog.get_logger(node="/gateway/mqtt").info("mqtt.link_lost", **facts)
    return out.getvalue()


def test_a_line_for_people_has_time_node_and_words() -> None:
    line = logged("console", io.StringIO(), message="The broker is gone.")
    assert line[2] == line[5] == ":"
    assert line[8:] == "  gateway/mqtt   The broker is gone.\n"


def test_a_line_in_the_journal_of_systemd_has_the_time_of_the_journal_alone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A service that sends its errors elsewhere has the variable too."""
    with (tmp_path / "journal").open("w+") as journal, (tmp_path / "file").open("w+") as file:
        status = os.fstat(journal.fileno())
        monkeypatch.setenv("JOURNAL_STREAM", f"{status.st_dev}:{status.st_ino}")
        for out in (journal, file, io.StringIO()):
            configure_logging(stream=out)
            structlog.get_logger(node="/gateway/mqtt").info("mqtt.link_lost", message="The broker is gone.")
            out.seek(0)
            assert out.read()[0 if out is journal else 10 :] == "gateway/mqtt   The broker is gone.\n"


def test_a_line_without_words_shows_its_event_and_facts() -> None:
    assert logged("console", io.StringIO(), url="mqtt://x", attempts=3).endswith(
        "mqtt.link_lost  url=mqtt://x  attempts=3\n"
    )


def test_a_line_for_programs_is_one_json_object() -> None:
    line = json.loads(logged("json", io.StringIO(), attempts=3))
    stamp = datetime.fromisoformat(line.pop("timestamp"))
    assert abs(stamp - datetime.now(UTC)) < timedelta(minutes=1)
    assert line == {"event": "mqtt.link_lost", "node": "/gateway/mqtt", "level": "info", "attempts": 3}


def test_an_outsider_cannot_break_the_line_or_steer_the_terminal() -> None:
    line = logged("console", Terminal(), message="on\n12:00:00 fake\x1b[2J\x07 Küche")
    assert line.endswith(r"on\n12:00:00 fake\x1b[2J\x07 Küche" + "\n")


@given(st.text())
def test_nothing_that_an_error_or_a_name_holds_steers_the_terminal(text: str) -> None:
    """No control characters but the ends of lines and our own colours, and no line that looks like one of ours."""
    out = Terminal()
    configure_logging("console", stream=out)
    error = ValueError(f"\x1b]0;owned\x07\n12:00:00  homebot  forged {text}")
    structlog.get_logger(node=f"/{text}").error("a.b", message=text, fact=text, exc_info=error)
    shown = out.getvalue().removeprefix("\x1b[31m").removesuffix("\x1b[0m\n")
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028\u2029\u202e]", shown)
    assert [line for line in shown.split("\n") if not line.startswith("  ")] == shown.split("\n")[:1]


def test_the_time_of_a_line_is_local_and_says_so_to_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "Asia/Kathmandu")
    time.tzset()
    try:
        stamp = json.loads(logged("json", io.StringIO()))["timestamp"]
        shown = logged("console", io.StringIO())[:5]
        there = datetime.now(timezone(timedelta(hours=5, minutes=45)))
    finally:
        monkeypatch.undo()
        time.tzset()
    assert stamp.endswith("+05:45")
    assert shown in {f"{there:%H:%M}", f"{there - timedelta(minutes=1):%H:%M}"}


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
    assert rest[-1] == "  ValueError: invalid literal for int() with base 10: 'boom'"


def test_lines_below_the_level_are_not_shown() -> None:
    out = io.StringIO()
    configure_logging(stream=out, level="warning")
    structlog.get_logger().info("a.b")
    assert out.getvalue() == ""


def test_an_unknown_level_is_refused() -> None:
    with pytest.raises(
        UsageError, match="'loud' is not a log level; choose one of debug, info, warning, error, critical"
    ):
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


def library_lines(out: io.StringIO) -> list[dict[str, object]]:
    return [json.loads(line) for line in out.getvalue().splitlines()]


def test_what_libraries_log_comes_in_the_same_format_from_warning_on() -> None:
    out = io.StringIO()
    configure_logging("json", stream=out)
    logging.getLogger("aiomqtt").info("not shown")
    logging.getLogger("aiomqtt").warning("lost %d messages", 3)
    (line,) = library_lines(out)
    assert (line["event"], line["node"], line["level"]) == ("log.library", "aiomqtt", "warning")
    assert line["message"] == "lost 3 messages"


def test_a_traceback_of_a_library_stays_within_its_line() -> None:
    out = io.StringIO()
    configure_logging("json", stream=out)
    try:
        int("boom")
    except ValueError:
        logging.getLogger("asyncio").exception("Task exception was never retrieved")
    (line,) = library_lines(out)
    assert "ValueError: invalid literal" in str(line["exception"])


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("no way to mqtt://robot:p@ss:w0rd@broker:1883", "no way to mqtt://robot:***@broker:1883"),
        ("GET /?token=s3cret&x=1", "GET /?token=***&x=1"),
        ("Authorization: Bearer s3cret", "Authorization: Bearer ***"),
        ("{'password': 's3cret', 'user': 'robot'}", "{'password': '***', 'user': 'robot'}"),
        ("the password of robot was refused", "the password of robot was refused"),
        ("ws://127.0.0.1:9090/a@b", "ws://127.0.0.1:9090/a@b"),
    ],
)
def test_secrets_in_what_libraries_say_are_not_shown(said: str, shown: str) -> None:
    out = io.StringIO()
    configure_logging("json", stream=out)
    logging.getLogger("websockets").error(said)
    assert [line["message"] for line in library_lines(out)] == [shown]


def test_a_library_that_repeats_itself_is_limited_and_one_that_slips_is_shown_as_it_is() -> None:
    out = io.StringIO()
    configure_logging("json", stream=out)
    for number in range(5):
        logging.getLogger("paho").error("failed for the %d. time", number)
    slip = logging.LogRecord("paho", logging.ERROR, __file__, 1, "no %d", ("number",), None)
    logging.getLogger().handlers[-1].handle(slip)  # pytest's own handlers raise at such a line
    assert [line["message"] for line in library_lines(out)] == ["failed for the 0. time", "no %d"]


def test_configuring_twice_says_everything_once() -> None:
    first, second = io.StringIO(), io.StringIO()
    configure_logging("json", stream=first)
    configure_logging("json", stream=second)
    logging.getLogger("aiomqtt").warning("lost")
    assert first.getvalue() == ""
    assert len(library_lines(second)) == 1


@pytest.mark.filterwarnings("default")
def test_a_warning_of_python_is_a_line_too() -> None:
    out = io.StringIO()
    configure_logging("json", stream=out)
    warnings.warn("this will change", FutureWarning, stacklevel=1)
    (line,) = library_lines(out)
    assert line["node"] == "py.warnings"
    assert "FutureWarning: this will change" in str(line["message"])


def test_a_reader_of_the_log_that_goes_away_disturbs_nobody() -> None:
    class Gone(io.StringIO):
        def write(self, _text: str) -> int:
            raise BrokenPipeError

    configure_logging(stream=Gone())
    structlog.get_logger().info("a.b")
    closed = io.StringIO()
    configure_logging(stream=closed)
    closed.close()
    structlog.get_logger().info("a.b")


def test_a_very_long_line_is_cut_and_tells_its_length() -> None:
    """A device may have a name of 40,000 characters."""
    out = io.StringIO()
    configure_logging(stream=out)
    structlog.get_logger().info("event", message="x" * 40_000)
    line = out.getvalue()
    assert len(line) < 1100
    assert "… (40,000 characters)" in line


def test_characters_that_turn_the_direction_of_text_are_shown_and_not_obeyed() -> None:
    """A device name may hold U+202E."""
    out = io.StringIO()
    configure_logging(stream=out)
    structlog.get_logger().info("event", message="lamp \u202e gnp")
    assert "lamp \\u202e gnp" in out.getvalue()


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("test.<locals>.Lamp.turn_off", "Lamp.turn_off() was called without await, so it did nothing: "),
        ("Door.hold.__aenter__", "Door.hold() was called without `async with`, so it did nothing: "),
    ],
)
def test_a_forgotten_await_is_an_error_that_names_the_call_and_its_place(name: str, told: str) -> None:
    async def forgotten() -> None:
        pytest.fail("nobody awaits it")

    forgotten.__qualname__ = name
    out = io.StringIO()
    configure_logging("json", stream=out)
    forgotten()  # type: ignore[unused-coroutine]
    line = json.loads(out.getvalue())
    assert (line["level"], line["event"]) == ("error", "python.forgotten_await")
    assert told in line["message"]
    assert "test_log.py:" in line["message"]
