"""Random houses and days: they cover what there is, and a failing day shrinks to the few things that make it fail.

Its devices are those of ``homebot.integrations.thesis``.
"""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import Phase, assume, find, given, settings
from tests.sizes import examples, nightly

from homebot.config import Table
from homebot.errors import ConfigError, UsageError
from homebot.house.description import parse_world
from homebot.house.kinds import FAULTS, KINDS
from homebot.testing import Day
from homebot.testing.strategies import days, houses, saved_if_failing
from homebot.testing.strategies.devices import FAULT_SETTINGS, KIND_SETTINGS, PAYLOADS

ROOT = Path(__file__).parents[2]
FOUND = settings(max_examples=2000, derandomize=True, database=None, phases=[Phase.generate, Phase.shrink])

LAMPS = houses(kinds=["lamp"], max_rooms=2, min_devices=1, max_devices=2, max_people=1)
LONELY = houses(
    kinds=["lamp"], max_rooms=2, min_devices=1, max_devices=2, faults=["deaf", "reverter"], max_people=0, max_errands=0
)

EMPTY = """\
[day]
start = "00:00"
length = "1h"

[rooms.hall]
doors = [
    "outside",
]
"""

PRESSED = f"""\
{EMPTY}
[devices.lamp]
kind = "lamp"
room = "hall"

[[happenings]]
at = "00:00"
what = "press"
device = "lamp"
command = "on"
"""

BROKEN_PROMISE = f"""\
{EMPTY}
[devices.lamp]
kind = "lamp"
room = "hall"

[devices.lamp.faults.reverter]

[[happenings]]
at = "00:00"
what = "press"
device = "lamp"
command = "on"

[[happenings]]
at = "00:00"
what = "tell"
device = "lamp"
command = "off"
"""


def goes_on_again(day: Day) -> bool:
    """Whether a lamp that hands switched on, and that then was told off, says on again."""
    wanted: dict[str, list[str]] = {}
    for event in day.play().since(0):
        commands = wanted.setdefault(event.who, [])
        if event.verb in {"told", "switch"}:
            commands.append(f"{event.verb} {event.what}")
        elif event.what == "on" and "switch on" in commands and commands[-1] == "told off":
            return True
    return False


def test_the_simplest_day_is_an_hour_in_an_empty_house_of_one_room() -> None:
    assert str(find(days(), lambda _: True, settings=FOUND)) == EMPTY


@pytest.mark.no_cover
@nightly
def test_a_lamp_that_reverts_is_found_and_its_day_has_nothing_else() -> None:
    assert (
        str(find(days(LONELY, what=["press", "tell"], max_length="1h"), goes_on_again, settings=FOUND))
        == BROKEN_PROMISE
    )


def is_pressed_while_its_cable_is_out(day: Day) -> bool:
    return any(
        pulled.what == "pull" and pressed.what == "press" and pulled.at < pressed.at < pulled.at + pulled.lasts
        for pulled in day.happenings
        for pressed in day.happenings
        if pulled.device == pressed.device
    )


def test_what_must_happen_one_after_the_other_shrinks_to_these_two() -> None:
    strategy = days(LAMPS, what=["press", "pull"], max_happenings=4, max_length="1h")
    day = find(strategy, is_pressed_while_its_cable_is_out, settings=FOUND)
    assert [(happening.what, happening.command) for happening in day.happenings] == [("pull", ""), ("press", "on")]
    assert [*day.world().devices] == ["lamp"]
    assert "people" not in day.house


def test_happenings_shrink_to_full_hours() -> None:
    day = find(days(LAMPS), lambda day: any(happening.at > 4000.0 for happening in day.happenings), settings=FOUND)
    assert [happening.at for happening in day.happenings] == [7200.0]
    assert (day.start % 3600.0, day.length % 3600.0) == (0.0, 0.0)


def has(part: str, number: int) -> Callable[[Table], bool]:
    def is_there(house: Table) -> bool:
        table = house.get(part, {})
        assert isinstance(table, dict | list)
        return len(table) >= number

    return is_there


@pytest.mark.parametrize("part", ["rooms", "devices", "people", "errands"])
def test_a_house_of_two_has_two_and_nothing_else(part: str) -> None:
    house = find(houses(), has(part, 2), settings=FOUND)
    needed = {"rooms", part} | ({"devices"} if part == "errands" else set())
    assert set(house) == needed
    assert {name: len(table) for name, table in house.items() if isinstance(table, dict | list)} == {
        name: 2 if name == part else 1 for name in needed
    }


@given(houses(max_rooms=6, max_devices=8, max_people=3))
@settings(max_examples=examples(30))
def test_every_house_can_be_lived_in(house: Table) -> None:
    parse_world(house, "house").run_until(3600.0)


@given(
    houses(max_rooms=2, min_devices=1, max_devices=3, max_people=0, max_errands=0, kinds=["lamp", "lock"], faults=False)
)
@settings(max_examples=15)
def test_a_house_keeps_to_its_bounds(house: Table) -> None:
    assert set(house) <= {"house", "rooms", "devices"}
    assert isinstance(house["rooms"], dict)
    assert len(house["rooms"]) <= 2
    devices = house["devices"]
    assert isinstance(devices, dict)
    assert 1 <= len(devices) <= 3
    assert {table["kind"] for table in devices.values()} <= {"lamp", "lock"}
    assert not any("faults" in table for table in devices.values())


@given(days(ROOT / "examples" / "houses" / "flat.toml", what=["press", "cut"], max_happenings=3, max_length="2h"))
@settings(max_examples=15)
def test_a_day_may_be_one_in_your_own_house(day: Day) -> None:
    assert "hall_lamp" in day.world().devices
    assert {happening.what for happening in day.happenings} <= {"press", "cut"}
    assert len(day.happenings) <= 3
    assert day.length <= 7200.0


def test_every_setting_of_every_kind_and_fault_is_drawn() -> None:
    """A new one must be given its numbers.

    Random houses have no tags, which need a reader outside virtual time; a power meter is that of all devices.
    """
    drawn = {kind: model for kind, model in KINDS.items() if kind != "tag"}
    assert {kind: set(table) for kind, table in KIND_SETTINGS.items()} == {
        kind: set(model.model_fields) - {"of"} for kind, model in drawn.items()
    }
    assert {fault: set(table) for fault, table in FAULT_SETTINGS.items()} == {
        fault: set(model.model_fields) for fault, model in FAULTS.items()
    }
    assert set(PAYLOADS) == set(drawn)


@pytest.mark.parametrize(
    ("ask", "reason"),
    [
        (lambda: houses(max_rooms=0), "max_rooms must be from 1 to 10, got 0"),
        (lambda: houses(min_devices=6), "min_devices must be from 0 to 5, got 6"),
        (lambda: houses(max_devices=-1), "max_devices must be"),
        (lambda: houses(min_devices=1, kinds=[]), "min_devices must be from 0 to 0, got 1"),
        (lambda: houses(kinds=["lamb"]), "'lamb' is no kind of device; known are lamp"),
        (lambda: houses(faults=["shy"]), "'shy' is no fault; known are"),
        (lambda: days(what=["shout"]), "'shout' is no happening; known are press"),
        (lambda: days(max_length="30m"), "max_length must be from 1h to 24h"),
        (lambda: days(max_happenings=-1), "max_happenings must be"),
    ],
)
def test_a_bound_that_cannot_be_is_refused_at_once(ask: Callable[[], object], reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        ask()


def test_a_house_that_is_none_is_refused_at_once() -> None:
    with pytest.raises(ConfigError, match="rooms: is missing"):
        days({})


def test_a_failing_day_is_saved_shrunk(tmp_path: Path) -> None:
    """The last one that fails is the simplest, and its text is in the report."""
    file = tmp_path / "days" / "failing.toml"

    @given(days(LAMPS))
    @settings(FOUND)
    def test_no_lamp_is_pressed(day: Day) -> None:
        with saved_if_failing(day, file):
            assert all(happening.what != "press" for happening in day.happenings)

    with pytest.raises(AssertionError) as caught:
        test_no_lamp_is_pressed()
    assert file.read_text() == PRESSED
    notes = "\n".join(caught.value.__notes__)
    assert f'Day.parse("""\n{PRESSED}""")' in notes
    assert f"the day is in {file}" in notes


def test_a_day_that_passes_or_is_turned_down_is_not_saved(tmp_path: Path) -> None:
    file = tmp_path / "day.toml"

    @given(days(LAMPS))
    @settings(FOUND, max_examples=5)
    def test_nothing(day: Day) -> None:
        with saved_if_failing(day, file):
            assume(day.start < 43_200.0)

    test_nothing()
    assert not file.exists()


@pytest.mark.parametrize(
    ("missing", "module"), [("hypothesis", "homebot.testing.strategies"), ("tomli_w", "homebot.testing.day")]
)
def test_without_the_extra_it_is_told_what_to_install(missing: str, module: str) -> None:
    program = f"import sys; sys.modules[{missing!r}] = None; import {module}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert "pip install 'homebot[testing]'" in done.stderr.splitlines()[-1]
