"""A day is plain data: it goes into a file and comes back the same, and is the same each time it is lived."""

from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.sizes import examples

from homebot.errors import ConfigError, UsageError
from homebot.testing import Day, DayEvent
from homebot.testing.strategies import days

ROOT = Path(__file__).parents[2]
HOUSE = """
[rooms.hall]
doors = ["outside"]

[devices.lamp]
kind = "lamp"
room = "hall"
faults = { reverter = { after = 60.0 } }
"""
MORNING = f"""
[day]
start = "06:30"
length = "2h"
{HOUSE}
[[happenings]]
at = "07:00"
what = "tell"
device = "lamp"
command = "on"

[[happenings]]
at = "06:45:00.5"
what = "restart"
lasts = "90s"
"""


@given(days())
@settings(max_examples=25)
def test_a_saved_day_comes_back_the_same(tmp_path_factory: pytest.TempPathFactory, day: Day) -> None:
    file = tmp_path_factory.getbasetemp() / "day.toml"
    day.save(file)
    assert Day.load(file) == day
    assert eval(repr(day), {"Day": Day}) == day  # noqa: S307  # as somebody copies it into a test


@given(st.text(st.characters(exclude_categories=["Cs"])), st.integers(0, 86_400_000), st.integers(0, 86_400_000))
@settings(max_examples=examples(40))
@example('"""', 1, 59_999)
@example("\\", 3_599_999, 0)
def test_any_command_and_any_millisecond_come_back_the_same(command: str, at: int, lasts: int) -> None:
    told = DayEvent(at / 1000, "tell", "lamp", command)
    pulled = DayEvent(at / 1000, "pull", "lamp", lasts=lasts / 1000)
    day = Day(Day.parse(HOUSE).house, [told, pulled])
    assert Day.parse(str(day)) == day
    assert eval(repr(day), {"Day": Day}) == day  # noqa: S307  # as above


def test_a_day_reads_as_its_file() -> None:
    day = Day.parse(MORNING)
    assert str(day) == (
        '[day]\nstart = "06:30"\nlength = "2h"\n\n'
        '[rooms.hall]\ndoors = [\n    "outside",\n]\n\n'
        '[devices.lamp]\nkind = "lamp"\nroom = "hall"\n\n'
        "[devices.lamp.faults.reverter]\nafter = 60.0\n\n"
        '[[happenings]]\nat = "06:45:00.500"\nwhat = "restart"\nlasts = "1m30s"\n\n'
        '[[happenings]]\nat = "07:00"\nwhat = "tell"\ndevice = "lamp"\ncommand = "on"\n'
    )


def test_the_file_of_a_house_is_a_day_in_which_nothing_happens() -> None:
    day = Day.load(ROOT / "examples" / "houses" / "family.toml")
    assert (day.start, day.length, day.happenings) == (0.0, 86_400.0, ())
    assert len(day.world().devices) >= 20


def test_a_day_cannot_be_changed_through_the_tables_it_was_made_of() -> None:
    tables = dict(Day.parse(HOUSE).house)
    day = Day(tables)
    tables.clear()
    assert "rooms" in day.house


def test_a_played_day_is_told_and_pressed_on_time() -> None:
    day = Day.parse(
        MORNING.replace('what = "restart"\nlasts = "90s"', 'what = "press"\ndevice = "lamp"\ncommand = "off"')
    )
    world = day.world()
    assert day.play(world).text() == (
        "0 06:45:00.500 lamp switch off\n0 06:45:00.500 lamp says off\n"
        "0 07:00:00.000 lamp told on\n0 07:00:00.000 lamp says on\n0 07:01:00.000 lamp says off\n"
    )
    assert world.now == day.end == 8.5 * 3600


@pytest.mark.parametrize(
    ("old", "new", "key", "reason"),
    [
        ('"06:30"', '"6.30"', "day", "'6.30' is not a time of day"),
        ('"06:30"', '"24:00"', "day.start", "must be from 00:00 to 23:59"),
        ('"2h"', '"0s"', "day.length", "must be above 0"),
        ('"2h"', '"7d"', "day.length", "less than a week"),
        ('"2h"', '"soon"', "day", "'soon' is not a duration"),
        ("length", "lenght", "day.lenght", "unknown key; did you mean length?"),
        ('"tell"', '"shout"', "happenings.0.what", "'press'"),
        ('"07:00"', '"7"', "happenings.0.at", "'7' is not a time of day"),
        ('"07:00"', '"09:00"', "happenings.0.at", "09:00 is not in the day, 06:30 to 08:30"),
        ('device = "lamp"', 'device = "lamb"', "happenings.0.device", "there is no device 'lamb'"),
        ('device = "lamp"\n', "", "happenings.0", "tell needs a device"),
        ('"tell"', '"cut"', "happenings.0", "command is not for cut, which takes device"),
        ('"90s"', '"-1s"', "happenings.1.lasts", "is not a duration"),
        ('"90s"', '"8d"', "happenings.1", "lasts must be from 0 to 604800 seconds"),
        ('kind = "lamp"', 'kind = "lamb"', "devices.lamp.kind", "must be one of lamp"),
        ("[rooms.hall]", "[garden]", "rooms", "is missing"),
        ("[[happenings]]", "[happenings]", "", "is invalid TOML"),
    ],
)
def test_what_is_wrong_is_told_with_file_key_and_reason(
    tmp_path: Path, old: str, new: str, key: str, reason: str
) -> None:
    file = tmp_path / "day.toml"
    assert old in MORNING
    file.write_text(MORNING.replace(old, new, 1))
    with pytest.raises(ConfigError) as caught:
        Day.load(file)
    assert caught.value.source == str(file)
    assert caught.value.key == key
    assert reason in caught.value.reason


def test_a_file_that_cannot_be_read_or_written_is_told_so(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.toml does not exist"):
        Day.load(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xff")
    with pytest.raises(ConfigError, match="not UTF-8"):
        Day.load(tmp_path / "bytes.toml")
    with pytest.raises(UsageError, match=r"bytes\.toml.* cannot be written"):
        Day.parse(HOUSE).save(tmp_path / "bytes.toml" / "day.toml")


@pytest.mark.parametrize(
    ("at", "command", "reason"),
    [(-1.0, "on", "at must be from 0"), (float("nan"), "on", "at must be from 0"), (0.0, "\ud800", "can be sent")],
)
def test_a_happening_that_cannot_be_is_refused(at: float, command: str, reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        DayEvent(at, "tell", "lamp", command)


def test_the_tables_of_a_house_hold_no_day() -> None:
    with pytest.raises(ConfigError, match=r"day: is not a table of a house"):
        Day({"day": {}, **Day.parse(HOUSE).house})
