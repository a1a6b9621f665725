"""What is printed on a terminal fits it, and nothing from outside steers it; elsewhere it is plain text."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import TextIO, cast

import pytest
from rich.cells import cell_len
from tests.cli.conftest import Homebot, _lamp

from homebot.cli import main
from homebot.cli.commands.top import HEADINGS, TopicRow
from homebot.cli.terminal import (
    print_line,
    print_rows,
    print_table,
    progress,
    rich_terminal,
    to_lines,
    to_table,
    without_empty,
)
from homebot.clock import Clock, ManualClock
from homebot.devices import QUERY_DEVICES, Found, QueryDevices
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.support.output import clean_output

HEAD = ("DEVICE", "SAYS", "GATEWAY", "STATE")
ROWS = (("lamp", "on", "mqtt", "fresh"), ("客廳的燈", "關, 40 %", "mqtt", "stale, unreachable"))
WIDTH = 30


class Terminal(io.StringIO):
    """Text that claims to be shown to somebody."""

    def isatty(self) -> bool:
        return True

    def lines(self) -> list[str]:
        """The lines that one sees, without what sets colours."""
        return [line.rstrip() for line in re.sub(r"\x1b\[[\d;]*m", "", self.getvalue()).splitlines()]


@pytest.fixture(autouse=True)
def _environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    monkeypatch.delenv("NO_COLOR", raising=False)


@contextmanager
def on_terminal() -> Iterator[Terminal]:
    """Standard output and error are as a command has them, on a terminal. No fixture, as pytest sets them per phase."""
    shown = Terminal()
    stream = cast("TextIO", shown)
    with redirect_stdout(stream), redirect_stderr(stream), clean_output():
        yield shown


def test_wide_characters_keep_the_columns_in_line(monkeypatch: pytest.MonkeyPatch) -> None:
    with on_terminal() as terminal:
        monkeypatch.setenv("COLUMNS", "80")
        print_table(HEAD, ROWS)
        places = [
            cell_len(line.partition(word)[0])
            for line, word in zip(terminal.lines(), ("GATEWAY", "mqtt", "mqtt"), strict=True)
        ]
        assert places == [20, 20, 20]


def test_rows_of_another_length_begin_in_the_same_column() -> None:
    with on_terminal() as terminal:
        print_rows([("on_off", "on", "since"), ("reads", "lamp/out"), ("光", "x", "y")])
        assert terminal.lines() == ["  on_off  on  since", "  reads   lamp/out", "  光      x  y"]


def test_no_line_is_wider_than_the_terminal_and_nothing_is_cut() -> None:
    with on_terminal() as terminal:
        print_table(HEAD[:2], [("a" * 50, "b" * 70), ("客" * 40, "關")])
        print_rows([("name", "one " * 20), ("名" * 30, "x", "y" * 40)], "title")
        assert max(cell_len(line) for line in terminal.lines()) <= WIDTH
        text = terminal.getvalue()
        assert [text.count(sign) for sign in "ab客關名y"] == [50 + text.count("name"), 70, 40, 1, 30, 40]


def test_columns_for_which_there_is_no_room_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with on_terminal() as terminal:
        print_table(HEAD, [ROWS[0]], if_room=("GATEWAY", "SAYS"))
        print_table(HEAD, [ROWS[0]], if_room=("GATEWAY",))
        monkeypatch.setenv("COLUMNS", "18")
        print_table(HEAD, [ROWS[0]], if_room=("GATEWAY", "SAYS"))
        whole, rows, narrow, less = (
            "DEVICE  SAYS  GATEWAY  STATE",
            "lamp    on    mqtt     fresh",
            "DEVICE  STATE",
            "lamp    fresh",
        )
        assert terminal.lines() == [
            whole,
            rows,
            whole,
            rows,
            narrow,
            less,
            "columns hidden, as",
            "the terminal is",
            "too narrow: SAYS,",
            "GATEWAY",
        ]


def test_next_go_columns_that_would_be_narrower_than_ten_characters() -> None:
    with on_terminal() as terminal:
        print_table(HEAD, [("a" * 30, "b" * 30, "c", "d")], if_room=("GATEWAY",), if_wide=("SAYS",))
        assert terminal.lines()[0].split() == ["DEVICE", "SAYS", "STATE"]
        print_table((*HEAD, "X" * 10), [("a" * 9, "b" * 30, "c", "d", "e")], if_room=("GATEWAY",), if_wide=("SAYS",))
        assert ["DEVICE", "STATE", "X" * 10] in [line.split() for line in terminal.lines()]


@pytest.mark.parametrize(
    ("width", "columns"), [(80, "TOPIC MSG/S WAITING LOST SLOWEST BY"), (50, "TOPIC MSG/S WAITING LOST")]
)
def test_a_live_table_cuts_names_and_leaves_columns_out_but_shows_its_numbers_whole(
    monkeypatch: pytest.MonkeyPatch, width: int, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    row = TopicRow("/gateway/mqtt/received_topics/of/a/house", 1234.5, 4321, 87654321, 0.0123, "/discovery/of/a/house")
    with on_terminal() as terminal:
        rich_terminal(sys.stdout).show_live(HEADINGS, [("title", [row.cells()])], if_wide=("BY", "SLOWEST", "WAITING"))
        place = next(at for at, line in enumerate(terminal.lines()) if line.startswith("TOPIC"))
        head, shown = terminal.lines()[place : place + 2]
        assert head.split() == columns.split()
        assert all(number in shown for number in ("1234.5", "4321", "87654321"))
        assert max(map(cell_len, (head, shown))) <= width


def test_nothing_from_outside_is_markup_or_steers_the_terminal() -> None:
    with on_terminal() as terminal:
        evil = "[red]:smile:[/]\x1b[2J\u202e"
        print_table(("A",), [(evil,)])
        print_rows([(evil,)], evil)
        print_line(evil, "bold")
        shown = "".join(terminal.lines())
        assert shown.count("[red]:smile:[/]") == 4
        assert not set(shown) & {"\x1b", "\u202e"}


def test_colours_are_for_states_and_not_where_they_are_not_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    with on_terminal() as terminal:
        print_table(("STATE", "AVAILABILITY"), [("fresh", "fresh, unreachable")], in_colour="AVAILABILITY")
        assert "\x1b[31mfresh, unreachable\x1b[0m" in terminal.getvalue()
        assert terminal.getvalue().count("\x1b[3") == 1
        monkeypatch.setenv("NO_COLOR", "1")
        terminal.truncate(0)
        print_table(("STATE", "AVAILABILITY"), [("fresh", "fresh, unreachable")], in_colour="AVAILABILITY")
        assert "\x1b[3" not in terminal.getvalue()
        monkeypatch.setenv("TERM", "dumb")
        terminal.truncate(0)
        print_line("all is well", "green")
        assert "\x1b" not in terminal.getvalue()


def test_where_there_is_no_terminal_the_text_is_plain(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(HEAD, ROWS, if_room=("GATEWAY",))
    assert capsys.readouterr().out == f"{to_table(HEAD, ROWS)}\n"
    print_rows(ROWS, "title")
    assert capsys.readouterr().out == "".join(
        f"{line}\n" for line in ("title", *(f"  {one}" for one in to_lines(ROWS)))
    )
    with progress("devices", 400) as show:
        show(200)
    print_line("done", "bold")
    assert capsys.readouterr() == ("done\n", "")


def test_progress_is_shown_and_taken_away(monkeypatch: pytest.MonkeyPatch) -> None:
    with on_terminal() as terminal:
        monkeypatch.setenv("COLUMNS", "80")
        with progress("devices", 400) as show:
            show(200)
        assert "devices" in terminal.getvalue()
        assert " 50%" in terminal.getvalue()
        assert terminal.getvalue().endswith("\x1b[2K")  # the line is erased
        before = terminal.getvalue()
        with progress("devices", 0) as show:
            show(0)
        assert terminal.getvalue() == before


def test_a_command_on_a_real_terminal_is_as_wide_as_that(homebot: Homebot) -> None:
    reads, writes = pty.openpty()
    fcntl.ioctl(writes, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 64, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    command = [sys.executable, "-m", "homebot", "--door", homebot.door, "devices", "--long"]
    done = subprocess.run(command, stdout=writes, stderr=writes, env=environment, timeout=120, check=True)
    os.close(writes)
    text = os.read(reads, 10_000).decode()
    os.close(reads)
    lines = re.sub(r"\x1b\[[\d;]*m", "", text).splitlines()
    assert done.returncode == 0
    assert lines[0].split() == ["DEVICE", "NAME", "TYPE", "AVAILABILITY", "LAST", "SEEN"]
    assert lines[-3].rstrip() == "columns hidden, as the terminal is too narrow: GATEWAY, COMMAND"
    assert max(map(len, lines)) <= 64


@pytest.mark.parametrize(
    "command", [["devices"], ["find", "lamp"], ["show", "Lamp"], ["doctor"], ["topic", "list"], ["node", "list"]]
)
def test_a_command_whose_output_is_piped_loads_neither_rich_nor_what_only_homebot_itself_needs(
    homebot: Homebot, command: list[str]
) -> None:
    code = (
        "import sys\nfrom homebot.cli import main\n"
        f"main(['--door', '{homebot.door}', *{command}])\n"
        "print({'rich', 'structlog', 'pydantic', 'pydantic_core', 'anyio', 'asyncio'} & set(sys.modules))\n"
        "import rich.console"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "set()"


def test_a_long_list_of_devices_shows_how_far_it_is(
    homebot_with: Callable[[Callable[[Graph], Node], Clock], Homebot], monkeypatch: pytest.MonkeyPatch
) -> None:
    homebot = homebot_with(_crowded, ManualClock(1_800_000_000))
    monkeypatch.setenv("COLUMNS", "100")
    with on_terminal() as terminal:
        assert main(["--door", homebot.door, "devices"]) == 0
    before, _, table = terminal.getvalue().rpartition("\x1b[2K")
    assert [share for share in (" 67%", "100%") if share in before] == [" 67%", "100%"]
    assert len(table.splitlines()) == 1 + 601 + 1
    assert table.count("\x1b[32mfresh") == 601


def _crowded(graph: Graph) -> Node:
    node = Node(graph, "discovery")

    def query(request: QueryDevicesRequest) -> QueryDevicesResponse:
        shown = range(601)[request.offset : request.offset + request.limit]
        lamp = _lamp(Time(sec=1_700_000_000, nanosec=0))
        found = [Found(device=lamp.model_copy(update={"id": f"{one:03}"}), score=1.0, reasons=()) for one in shown]
        return QueryDevicesResponse(success=True, results=tuple(found), total=601)

    node.create_service(QueryDevices, QUERY_DEVICES, query)
    return node


def test_columns_are_as_wide_as_they_need_to_be() -> None:
    assert to_table(("A", "B"), [("long", "x"), ("s", "y")]) == "A     B\nlong  x\ns     y"


def test_an_endless_cell_is_cut_and_spoils_no_other_row() -> None:
    assert to_table(("ID", "B"), [("x" * 30_000, "y")]) == f"ID{' ' * 48}B\n{'x' * 47}…  y"
    assert to_table(("ID",), [("x" * 48,)]) == f"ID\n{'x' * 48}"


def test_control_characters_are_shown_and_count_as_they_are_shown() -> None:
    assert to_table(("ID",), [("a\x1b[31m",)]) == "ID\na\\x1b[31m"
    assert to_table(("ID",), [("\x1b" * 40,)]) == "ID\n" + ("\\x1b" * 12)[:47] + "…"


def test_lines_may_be_of_different_lengths() -> None:
    """The last cell of a row makes no column wider."""
    assert to_lines([("a", "long value that ends the line"), ("bc", "x", "y"), ()]) == [
        "a   long value that ends the line",
        "bc  x  y",
        "",
    ]
    assert to_lines([("x" * 300,)]) == [f"{'x' * 199}…"]


def test_columns_that_may_be_empty_are_left_out_where_they_are() -> None:
    assert without_empty({"B", "C"}, ("A", "B", "C"), [("1", "", "x"), ("", "", "")]) == (
        ["A", "C"],
        [["1", "x"], ["", ""]],
    )
