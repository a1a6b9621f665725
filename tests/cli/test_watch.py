"""``homebot watch`` against a running homebot, and its lines."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import cycle
from typing import Any, cast

import pytest
from tests.cli.test_guides import HOUSE
from tests.patience import PATIENCE
from tests.shell import homebot_in
from tests.whole_house import WHOLE_HOUSE

from homebot.cli.commands.watch import MAX_LINES, _LinePrinter
from homebot.cli.watch_lines import HouseLines, WatchLine, fitted
from homebot.devices.command_messages import Setting
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.wording.json_message import JsonMessage
from homebot.messages import Time

pytestmark = pytest.mark.slow
HOMEBOT = (sys.executable, "-m", "homebot")


def _environment(door: str) -> dict[str, str]:
    return {**os.environ, "HOMEBOT_DOOR": door}


@pytest.fixture(scope="module")
def door(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    until = ("found hall_lamp", "found front_door", "is running")
    with homebot_in(tmp_path_factory.mktemp("house"), house=HOUSE, until=until) as homebot:
        yield homebot.door


def _watch(door: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*HOMEBOT, "watch", *arguments],
        env=_environment(door),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _do(door: str, *arguments: str) -> None:
    subprocess.run(
        [*HOMEBOT, "do", *arguments], env=_environment(door), check=False, capture_output=True, timeout=PATIENCE
    )


def _waiting(pipe: int) -> str:
    try:
        return os.read(pipe, 1_000_000).decode()
    except BlockingIOError:
        return ""


def _first_lines(door: str, watch: subprocess.Popen[str], device: str) -> list[str]:
    """Return the lines after commands to *device*, as when the subscription begins is not visible from outside."""
    assert watch.stdout is not None
    os.set_blocking(watch.stdout.fileno(), False)
    text, words = "", cycle(("on", "off"))
    while text.count("as commanded") < 2 or "→" not in text:
        _do(door, device, next(words))
        text += _waiting(watch.stdout.fileno())
    watch.send_signal(signal.SIGINT)
    return (text + watch.communicate(timeout=PATIENCE)[0]).splitlines()


@WHOLE_HOUSE
def test_a_command_and_the_change_are_a_line_each(door: str) -> None:
    lines = _first_lines(door, _watch(door), "Hall lamp")
    cells = [line.split()[1:] for line in lines]  # the light service commands it too, and some commands change nothing
    commands = [number for number, one in enumerate(cells) if one[:2] == ["hall_lamp", "→"]]
    changes = [[each[:4] for each in cells[number + 1 :]] for number in commands]
    words = [cells[number][2] for number in commands]
    pairs = zip(words, changes, strict=True)
    assert any(["hall_lamp", word, "as", "commanded"] in later for word, later in pairs), lines
    assert "\x1b" not in "".join(lines)


@WHOLE_HOUSE
def test_json_has_an_object_a_line_and_a_query_leaves_others_out(door: str) -> None:
    watch = _watch(door, "--json", "light")
    _do(door, "Front door", "lock")
    found = [json.loads(line) for line in _first_lines(door, watch, "Hall lamp")]
    assert {one["device"] for one in found} == {"hall_lamp"}
    shown = [one for one in found if one["kind"] != "outcome"]  # of one that changed nothing
    assert {one["kind"] for one in shown} == {"command", "change"}
    assert all(isinstance(one["values"]["on_off"], bool) and one["issuer"] for one in shown)


@WHOLE_HOUSE
def test_a_query_that_is_not_understood_is_refused(door: str) -> None:
    watch = _watch(door, "temperature >")
    _, errors = watch.communicate(timeout=PATIENCE)
    assert (watch.returncode, errors.startswith("homebot: ")) == (1, True)


@WHOLE_HOUSE
def test_a_query_that_nothing_matches_yet_is_said(door: str) -> None:
    watch = _watch(door, "nosuch")
    assert watch.stderr is not None
    assert watch.stderr.readline() == "homebot: so far no device has the word 'nosuch'\n"
    watch.send_signal(signal.SIGINT)
    watch.communicate(timeout=PATIENCE)


@WHOLE_HOUSE
def test_a_reader_that_has_enough_ends_it_quietly(door: str) -> None:
    watch = _watch(door)
    assert watch.stdout is not None
    watch.stdout.close()
    for word in ("on", "off") * 20:
        _do(door, "Hall lamp", word)
        if watch.poll() is not None:
            break
    assert watch.stderr is not None
    assert (watch.wait(PATIENCE), watch.stderr.read()) == (0, "")
    watch.stderr.close()


def test_a_flood_is_counted(capsys: pytest.CaptureFixture[str]) -> None:
    printer = _LinePrinter({}, as_json=False)
    for number in range(MAX_LINES + 130):
        printer.print(WatchLine(Time(sec=0, nanosec=0), "change", "lamp", "", {}, str(number)), 10.0)
    printer.end_second(10.9)
    printer.end_second(11.0)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == MAX_LINES + 1
    assert lines[-1] == "… 130 more"


def test_why_is_cut_first_and_then_the_issuer() -> None:
    cells = ("12:00:00.0", "lamp", "on", "because the motion sensor reported motion", "light_service")
    assert fitted(cells, None).endswith("because the motion sensor reported motion  light_service")
    assert fitted(cells, 80).split("  ")[-1] == "light_service"
    assert "…" in fitted(cells, 80)
    assert all(len(fitted(cells, width)) <= width for width in range(20, 140))


def test_a_change_without_a_reason_waits_for_the_journal_and_no_longer() -> None:
    lines, zero = HouseLines({}), {"sec": 1, "nanosec": 0}
    reading = {"part": "", "capability": "on_off", "value": True}
    change = cast("Any", JsonMessage({"device": "lamp", "readings": [reading], "told_at": zero}))
    lines.add_change(change, 10.0)
    assert list(lines.pop(10.5)) == []
    assert [line.why for line in lines.pop(11.0)] == [""]
    lines.add_change(change, 12.0)
    assert list(lines.pop(20.0)) == []  # the same value is no change


def _changed(on: bool) -> Any:  # noqa: FBT001
    reading = {"part": "", "capability": "on_off", "value": on}
    return JsonMessage({"device": "lamp", "readings": [reading], "told_at": {"sec": 1, "nanosec": 0}})


def _reported(on: bool, cause: str) -> JournalEntry:  # noqa: FBT001
    settings, at = (Setting.of("on_off", on),), Time(sec=1, nanosec=0)
    return JournalEntry(
        kind="reported", at=at, device="lamp", command="c", issuer="/app", settings=settings, cause=cause
    )


@pytest.mark.parametrize(
    ("cause", "said"),
    [
        ("command", ("as commanded", "app")),
        ("person", ("by hand", "")),
        ("program", ("by another program", "")),
        ("device", ("by itself", "")),
        ("unknown", ("by hand or by itself", "")),
    ],
)
def test_a_hand_that_is_related_to_a_command_is_not_blamed_on_its_app(cause: str, said: tuple[str, str]) -> None:
    lines = HouseLines({})
    lines.add_change(_changed(on=False), 1.0)
    lines.add_entry(_reported(on=False, cause=cause), 1.1)
    assert [(line.why, line.issuer) for line in lines.pop(20.0)] == [said]


def test_a_report_that_changed_nothing_explains_no_later_change_by_hand() -> None:
    lines = HouseLines({})
    lines.learn("lamp", _changed(on=True).readings)
    lines.add_entry(_reported(on=True, cause="command"), 1.0)
    lines.add_change(_changed(on=False), 100.0)
    lines.add_change(_changed(on=True), 200.0)
    assert [(line.value, line.why, line.issuer) for line in lines.pop(300.0)] == [("off", "", ""), ("on", "", "")]


def test_each_press_is_a_line_also_one_equal_to_the_one_before() -> None:
    lines = HouseLines({})
    for number, press in enumerate(("single", "single", "double", "single", "single")):
        reading = {"part": "", "capability": "press", "value": press}
        fields = {"device": "button", "readings": [reading], "told_at": {"sec": number, "nanosec": 0}}
        lines.add_change(cast("Any", JsonMessage(fields)), float(number))
    assert [line.value for line in lines.pop(20.0)] == ["single", "single", "double", "single", "single"]


@WHOLE_HOUSE
def test_top_prints_one_table_into_a_pipe_and_a_line_a_sample_as_json(door: str) -> None:
    top = [*HOMEBOT, "top"]
    table = subprocess.run(
        top, env=_environment(door), capture_output=True, text=True, timeout=PATIENCE, check=True
    ).stdout
    assert table.startswith("TOPIC ")
    assert "/discovery/states" in table
    assert "loop lag" in table.splitlines()[-1]
    with subprocess.Popen([*top, "--json"], env=_environment(door), stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        found = [json.loads(process.stdout.readline()) for _ in range(2)]
        process.send_signal(signal.SIGINT)
    assert all({"/rosout", "/discovery/states"} <= {one["topic"] for one in load["topics"]} for load in found)


@WHOLE_HOUSE
def test_top_takes_the_whole_terminal_and_gives_it_back(door: str) -> None:
    ours, theirs = os.openpty()
    environment = {**_environment(door), "TERM": "xterm", "LINES": "12", "COLUMNS": "90"}
    process = subprocess.Popen([*HOMEBOT, "top"], env=environment, stdin=theirs, stdout=theirs, stderr=theirs)
    os.close(theirs)
    shown = ""
    while shown.count("loop lag") < 2:
        shown += os.read(ours, 65536).decode()
    process.send_signal(signal.SIGINT)
    while "\x1b[?1049l" not in shown:
        shown += os.read(ours, 65536).decode()
    process.wait(PATIENCE)
    os.close(ours)
    assert shown.startswith("\x1b[?1049h")
    frame = shown.split("loop lag")[1]
    assert frame.count("\r\n") < 12


@pytest.mark.parametrize("width", [None, 120])
def test_a_long_value_leaves_the_issuer_in_its_column(width: int | None) -> None:
    """It moved behind `color temperature 3000 K`."""
    lines = [fitted(("12:00:00.0", "lamp", value, "", "local"), width) for value in ("on", "color temperature 3000 K")]
    assert len({line.index("local") for line in lines}) == 1
