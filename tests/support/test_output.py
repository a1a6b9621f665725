"""Output that nobody has to wait for: order, losses, the end; and that no stranger steers a terminal through."""

import io
import itertools
import json
import os
import re
import sys
import threading
import time
from collections.abc import Iterator
from typing import TextIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.patience import PATIENCE

from homebot.support.output import CleanText, OutputQueue, QueuedText, clean_output, queued_output


class Pipe:
    """A pipe that is read when the test says so."""

    def __init__(self) -> None:
        self.reads, self.writes = os.pipe()
        self._is_unread = False

    def read(self, size: int = 1 << 20) -> bytes:
        return os.read(self.reads, size)

    def read_until(self, end: bytes) -> bytes:
        found = b""
        while not found.endswith(end):
            found += self.read()
        return found

    def stop_reading(self) -> None:
        """Let nobody be there who will ever read it."""
        if not self._is_unread:
            os.close(self.reads)
        self._is_unread = True

    def close(self) -> None:
        self.stop_reading()
        os.close(self.writes)


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    made = Pipe()
    yield made
    made.close()


def test_what_is_put_is_written_in_order(pipe: Pipe) -> None:
    queue = OutputQueue(pipe.writes)
    for number in range(1000):
        queue.put(f"{number}\n")
    assert queue.drain(30)
    assert pipe.read_until(b"999\n").decode().splitlines() == [str(number) for number in range(1000)]


def test_a_reader_that_pauses_delays_nobody_and_is_told_what_it_missed_where_it_missed_it(pipe: Pipe) -> None:
    queue = OutputQueue(pipe.writes, most=200_000)
    started = time.monotonic()
    for number in range(100_000):
        queue.put(f"{number:07}\n")
    assert time.monotonic() - started < 30
    assert queue.lost > 0
    assert not queue.drain(0.01)

    lines: list[str] = []
    rest = b""
    while not lines or lines[-1] != "the end":
        *whole, rest = (rest + pipe.read()).split(b"\n")
        lines += [line.decode() for line in whole]
        if lines and "lost" in lines[-1]:
            queue.put("the end\n")
    numbers = [int(line) for line in lines if line.isdecimal()]
    assert numbers == list(range(len(numbers)))
    assert lines[-2] == f"… {100_000 - len(numbers):,} lines were lost here, because they were not read in time"
    assert queue.lost == 100_000 - len(numbers)


def test_a_computer_that_stands_still_takes_no_time_from_what_is_written_at_the_end(pipe: Pipe) -> None:
    hours = itertools.count(0, 3600)
    queue = OutputQueue(pipe.writes, now=lambda: float(next(hours)))
    queue.put("x" * 1_000_000)
    queue.put("end")
    reader = threading.Timer(0.3, pipe.read_until, [b"end"])
    reader.start()
    assert queue.drain(PATIENCE)
    reader.join()


def test_a_reader_that_has_gone_costs_nothing_more(pipe: Pipe) -> None:
    queue = OutputQueue(pipe.writes)
    pipe.stop_reading()
    for _ in range(1000):
        queue.put("x" * 1000)
    assert queue.drain(30)


def test_many_threads_lose_nothing_and_break_no_line(pipe: Pipe) -> None:
    queue = OutputQueue(pipe.writes)

    def put(letter: str) -> None:
        for _ in range(200):
            queue.put(letter * 50 + "\n")

    threads = [threading.Thread(target=put, args=(letter,)) for letter in "abcd"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    queue.put("end\n")
    lines = pipe.read_until(b"end\n").decode().splitlines()[:-1]
    assert sorted(lines) == sorted(letter * 50 for letter in "abcd" for _ in range(200))


def test_in_the_block_prints_are_queued_and_after_it_things_are_as_before(
    pipe: Pipe, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = open(pipe.writes, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    monkeypatch.setattr(sys, "stdout", stream)
    monkeypatch.setattr(sys, "stderr", stream)
    with queued_output() as lost_lines:
        assert isinstance(sys.stdout, QueuedText)
        assert isinstance(sys.stderr, QueuedText)
        assert sys.stdout.queue is sys.stderr.queue  # one terminal, one order
        sys.stdout.write("out\n")
        sys.stderr.write("error\n")
        assert lost_lines() == 0
    after: object = sys.stdout
    assert after is stream
    assert pipe.read_until(b"error\n") == b"out\nerror\n"


def test_leaving_the_block_takes_no_longer_than_the_last_chance(pipe: Pipe, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = open(pipe.writes, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    monkeypatch.setattr(sys, "stderr", stream)
    started = time.monotonic()
    with queued_output():
        assert isinstance(sys.stderr, QueuedText)
        queue = sys.stderr.queue
        for _ in range(10_000):
            sys.stderr.write("nobody reads this\n" * 10)
    assert time.monotonic() - started < 30
    pipe.stop_reading()
    assert queue.drain(PATIENCE)  # else it writes to what is opened next, which gets the number of the pipe


def test_a_stream_without_a_file_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    before: TextIO = sys.stderr
    with queued_output():
        assert sys.stderr is before


@given(st.text())
def test_nothing_that_is_printed_steers_a_terminal(text: str) -> None:
    out = io.StringIO()
    print(text, file=CleanText(out))
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028\u2029\u202e]", out.getvalue())


@given(st.text())
def test_json_that_is_printed_stays_the_same_json(text: str) -> None:
    out = io.StringIO()
    print(json.dumps([text], ensure_ascii=False), file=CleanText(out))
    assert json.loads(out.getvalue()) == [text]


def test_what_the_command_line_prints_and_complains_of_is_clean(capsys: pytest.CaptureFixture[str]) -> None:
    with clean_output():
        sys.stdout.write("a device \x1b]0;owned\x07\n")
        sys.stderr.write("an error \x9b31m\n")
    assert capsys.readouterr() == ("a device \\u001b]0;owned\\u0007\n", "an error \\u009b31m\n")
