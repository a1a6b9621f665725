"""What the history and the journal tell becomes days in which only persons have habits."""

from dataclasses import replace
from zoneinfo import ZoneInfo

import pytest
from tests.recorded_house import HOUSE, entry, states

from homebot.devices.client_rights import issuer_of_client
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.trigger import Trigger
from homebot.features.habits.days import DAY, Happening
from homebot.features.habits.habit import TriedHabit
from homebot.features.habits.messages import HabitProposal
from homebot.features.habits.proposal import is_same, proposal_of, undone_commands
from homebot.features.habits.recorded import Home, recorded_days
from homebot.features.habits.trial import try_habits
from homebot.features.routines.text import read_routines
from homebot.words.conditions import read_condition
from homebot.words.device_words import DeviceWords
from homebot.words.triggers import read_trigger

BERLIN = Home(ZoneInfo("Europe/Berlin"), 52.5, 13.4)
START = 1_767_567_600.0  # Monday, 2026-01-05, midnight in Berlin
WORDS = DeviceWords(HOUSE)
OWNER = issuer_of_client("owner")
TWO = "hall_lamp_two"


def steps(*entries: JournalEntry) -> list[str]:
    history = [states(TWO, "on_off", (START, "false"), (START + 60.4, "true"))]
    return [one.step for one in recorded_days(WORDS, history, entries, BERLIN).events if one.step]


def test_what_is_done_by_hand_or_by_the_owner_is_a_persons() -> None:
    assert steps(entry("changed", START + 60, TWO, cause="person", on_off=True)) == ["Hall lamp two on"]
    assert steps(entry("requested", START + 60, TWO, OWNER, on_off=True)) == ["Hall lamp two on"]
    assert steps(entry("requested", START + 60, TWO, "client:wall", on_off=True)) == ["Hall lamp two on"]  # a page


@pytest.mark.parametrize(
    "by_others",
    [
        entry("changed", START + 60, TWO, cause="device", on_off=True),
        entry("changed", START + 60, TWO, cause="unknown", on_off=True),
        entry("requested", START + 60, TWO, "/lights_out", on_off=True),
        entry("requested", START + 60, TWO, "client:agent", trigger=Trigger(kind="program"), on_off=True),
        entry("requested", START + 60, TWO, "client:local", trigger=Trigger(kind="program"), on_off=True),
        entry("requested", START + 60, TWO, OWNER, trigger=Trigger(kind="program"), on_off=True),
        entry("requested", START + 60, TWO, OWNER, trigger=Trigger(scene="Film"), on_off=True),
        entry("requested", START + 60, TWO, OWNER, trigger=Trigger(kind="timer"), on_off=True),
        entry("requested", START + 60, "front_door_lock", OWNER, lock="unlocked"),
    ],
)
def test_what_others_do_and_what_always_asks_is_no_habit(by_others: JournalEntry) -> None:
    assert steps(by_others) == []


def test_a_refused_command_is_no_habit() -> None:
    asked = entry("requested", START + 60, TWO, OWNER, command="c", on_off=True)
    assert steps(asked, entry("judged", START + 60, TWO, OWNER, command="c", refused=True)) == []


def test_a_change_and_its_cause_are_one_happening() -> None:
    deed = entry("requested", START + 60, TWO, OWNER, on_off=True)
    history = [states(TWO, "on_off", (START, "false"), (START + 60.4, "true"))]
    texts = [one.text for one in recorded_days(WORDS, history, [deed], BERLIN).events]
    assert texts == ["Hall lamp two off", "Hall lamp two on"]


def test_each_press_is_a_trigger() -> None:
    pressed = states("hall_button", "press", (START, "double"), (START + 1, "double"))
    days = recorded_days(WORDS, [pressed], [], BERLIN)
    one = Happening(START, "hall_button", " press", "Hall button press double", is_press=True)
    assert days.events == [one, replace(one, at=START + 1)]


def test_the_conditions_are_those_of_the_place_and_of_the_people() -> None:
    home = states("household", "at_home", (START, "true"), (START + 8 * 3600, "false"))
    anna = states("anna", "at_home", (START + 9 * 3600, "true"))
    motion = states("hall_motion", "occupancy", (START + 7 * 3600, "true"), (START + 7 * 3600 + 90, "false"))
    week = states(TWO, "on_off", (START + 6 * DAY, "true"))
    days = recorded_days(WORDS, [home, anna, motion, week], [], BERLIN)

    def held(at: float, device: str = TWO) -> set[str]:
        return {text for text, holds in days.conditions_on(device).items() if holds(at)}

    morning = {"on weekdays", "sun is down", "somebody is home"}
    assert held(START + 7 * 3600) == {*morning, "somebody in hall"}
    assert held(START + 7 * 3600, "bath_heating") == morning
    assert held(START + 9 * 3600 + 9) == {"on weekdays", "sun is up", "Anna is home", "nobody in hall"}
    assert held(START + 5.5 * DAY) == {"on weekends", "sun is up", "nobody in hall"}
    assert all(read_condition(one) for one in days.conditions)
    assert all(read_trigger(one) for one in days.moments)
    assert days.midnight(START + DAY + 1) == START + DAY


def test_a_day_of_the_week_is_a_condition_once_it_came_often_enough() -> None:
    five_weeks = states(TWO, "on_off", (START, "false"), (START + 29 * DAY, "true"))
    days = recorded_days(WORDS, [five_weeks], [], BERLIN)
    assert {text for text, holds in days.conditions.items() if holds(START + 7 * DAY)} == {
        "on weekdays",
        "on mon",
        "sun is down",
    }


def test_a_recorded_habit_becomes_a_routine_with_its_proof() -> None:
    motion, lamp, deeds = [], [], []
    for day in range(14):
        at = START + day * DAY + (18 + day % 5) * 3600
        motion += [(at, "true"), (at + 90, "false"), (at + 4000, "true"), (at + 4090, "false")]
        lamp += [(at + 3600, "false")]
        if day != 4:
            deeds.append(entry("changed", at + 20, TWO, cause="person", on_off=True))
            lamp.append((at + 20, "true"))
        deeds.append(entry("changed", at + 4020, TWO, cause="person", on_off=True))
        lamp += [(at + 4020, "true"), (at + 5000, "false")]
    history = [states("hall_motion", "occupancy", *motion), states(TWO, "on_off", *sorted(lamp))]
    days = recorded_days(WORDS, history, deeds, BERLIN)
    found = proposal_of(next(habit for habit in try_habits(days) if isinstance(habit, TriedHabit)))
    assert found.proof == (
        "in the week of the trial you did this within 20 s 14 of 14 times; "
        "a routine would be right 85 to 99 % of the time"
    )
    (routine,) = read_routines(found.text, "the habit")
    assert routine.table["when"] == ["Hall motion occupied"]
    assert routine.table["do"] == ["Hall lamp two on"]
    assert len(found.occasions) == 28


def test_a_rejected_habit_is_the_same_if_its_time_moves_a_little() -> None:
    habit = proposal_of_time("22:40")
    assert is_same(habit, "23:10", "Blind closed")
    assert not is_same(habit, "20:00", "Blind closed")
    assert not is_same(habit, "22:40", "Hall lamp two off")
    assert is_same(proposal_of_time("23:50"), "0:10", "Blind closed")
    assert is_same(proposal_of_time("sunset + 20m"), "sunset", "Blind closed")
    assert not is_same(proposal_of_time("sunset"), "sunrise", "Blind closed")


def proposal_of_time(when: str) -> HabitProposal:
    return HabitProposal(id="1", name="", proof="", when=when, do="Blind closed")


def test_an_undone_command_is_one_that_a_person_reverts_within_minutes() -> None:
    given = [entry("requested", START + 3600 * one, TWO, "/habit", on_off=True) for one in range(7)]
    undone = [entry("changed", START + 3600 * one + 120, TWO, cause="person", on_off=False) for one in (4, 5, 6)]
    late = entry("changed", START + 3600 * 3 + 900, TWO, cause="person", on_off=False)
    same = entry("changed", START + 3600 * 2 + 9, TWO, cause="person", on_off=True)
    assert undone_commands([*given, *undone, late, same], "/habit") == (3, 5)
    assert undone_commands([*given, *undone], "/other") == (0, 0)
