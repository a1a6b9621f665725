"""What must hold for a routine to run, as text."""

from datetime import time

import pytest

from homebot.errors import UsageError
from homebot.words.conditions import AnyOf, Matches, OnDays, SinceMoment, SunIs, check_possible, read_condition
from homebot.words.days import CalendarDays
from homebot.words.times import SunMoment, SunSpan, TimeSpan
from homebot.words.triggers import MessageComes


def test_the_sun_days_and_times() -> None:
    assert read_condition("sun is down") == SunIs(is_up=False)
    assert read_condition("on weekends") == OnDays(CalendarDays(frozenset({5, 6})))
    assert read_condition("after 22:00") == read_condition("After 22:00") == TimeSpan(time(22), time())
    assert read_condition("On weekdays") == read_condition("on weekdays")
    assert read_condition("after sunset - 30m") == SunSpan(SunMoment("sunset", "-30m"), time())
    assert read_condition("not between dusk and 6:30") == SunSpan(time(6, 30), SunMoment("dusk", "0s"))
    assert read_condition("between 22:00 and 6:30") == TimeSpan(time(22), time(6, 30))


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("after 22:00", "23:59", "21:59"),
        ("before 6:30", "06:29", "06:30"),
        ("between 22:00 and 6:30", "00:00", "12:00"),
        ("between 9:00 and 17:00", "09:00", "17:00"),
    ],
)
def test_a_span_may_last_over_midnight(text: str, inside: str, outside: str) -> None:
    span = read_condition(text)
    assert isinstance(span, TimeSpan)
    assert span.has(time.fromisoformat(inside))
    assert not span.has(time.fromisoformat(outside))


@pytest.mark.parametrize(
    ("text", "is_none"),
    [
        *(("hall lamp on", False), ("not hall lamp on", True), ("no window open", True)),
        *(("somebody in study", False), ("nobody in study", True), ("nobody sleeps in bedroom", True)),
    ],
)
def test_a_state_holds_or_does_not(text: str, *, is_none: bool) -> None:
    found = read_condition(text)
    assert isinstance(found, Matches)
    assert found.is_none is is_none


def test_or_joins_conditions_of_all_kinds() -> None:
    parts = ("sun is down", "between 22:00 and 6:30", "no window open", "Anna is home")
    assert read_condition(" or ".join(parts)) == AnyOf(tuple(map(read_condition, parts)))
    assert isinstance(read_condition("no window open or door open"), Matches), "none of both"
    assert isinstance(read_condition("window open or no door open"), AnyOf)


@pytest.mark.parametrize("first", ["window open for 5m", "hall lamp on for less than 2h"])
def test_a_state_that_lasts_is_joined_to_another_one(first: str) -> None:
    """At the end a length is that of all states before it."""
    rest = "door open or hatch open for 3m"
    assert read_condition(f"{first} or {rest}") == AnyOf((read_condition(first), read_condition(rest)))
    assert isinstance(read_condition(rest), Matches)


@pytest.mark.parametrize("text", ["not hall button press double", "no hall button press"])
def test_a_press_is_not_denied(text: str) -> None:
    """It would be one of a button that is not in the hall."""
    with pytest.raises(UsageError, match="into `else`"):
        read_condition(text)


def test_not_denies_times_days_and_the_sun() -> None:
    assert read_condition("not sun is down") == SunIs(is_up=True)
    assert read_condition("not on weekdays") == OnDays(CalendarDays(frozenset({5, 6})))
    assert read_condition("not between 22:00 and 6:30") == TimeSpan(time(6, 30), time(22))
    assert read_condition("on sat and sun") == OnDays(CalendarDays(frozenset({5, 6})))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("22:00", "write it like 'after 22:00'"),
        ("sun down", "write it like 'sun is down'"),
        ("hall lamp off and sun is down", "write 'sun is down' for itself"),
        ("hall lamp on and no window open", "write each as a condition for itself"),
        ("Anna or Ben is home", "names no state"),
        ("not before 0:00", "would never hold"),
        ("temperature of hall rises above 25 °C", "write 'temperature of hall above 25 °C'"),
        ("temperature of hall falls below temperature of study", "write 'temperature of hall below temperature of"),
    ],
)
def test_a_mistake_is_named(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        read_condition(text)


TOGETHER: list[tuple[list[str], str]] = [
    (["after 21:00", "before 4:00"], "write 'between 21:00 and 4:00'"),
    (["Before 4:00", "hall lamp on", "after 21:00"], "write 'between 21:00 and 4:00'"),
    (["after sunset - 30m", "before sunrise"], "write 'between sunset - 30m and sunrise'"),
    (["after sunset", "before 4:00"], "write 'between sunset and 4:00'"),
    (["on weekdays", "on sat,sun"], "leave out one of them"),
    (["sun is up", "it is dark"], "leave out one of them"),
    (["hall lamp on", "not hall lamp on"], "leave out one of them"),
    (["after 22:00", "before 22:00"], "leave out one of them"),
    (["sun elevation above 10°", "sun elevation below 4°"], "leave out one of them"),
    (["sun elevation above 4°", "sun elevation below 10°", "sun elevation above 6°"], ""),
    (["after 6:00", "before 21:00"], ""),
    (["after sunset - 30m", "before sunset"], ""),
    (["after 19:00", "before sunset"], ""),
    (["after sunrise", "before sunset + 1h", "on mon,tue", "on weekdays"], ""),
]
"""Conditions, and what is told of those that never hold together."""


@pytest.mark.parametrize(("texts", "hint"), TOGETHER)
def test_conditions_that_never_hold_together_are_told_with_the_text_to_write(texts: list[str], hint: str) -> None:
    if not hint:
        check_possible(texts)
        return
    with pytest.raises(UsageError, match=f"never hold together; {hint}"):
        check_possible(texts)


@pytest.mark.parametrize(
    ("text", "is_over"),
    [
        ("text of last cleaning over 3d ago", True),
        ("text of last cleaning was less than 3d ago", False),
        ("not text of last cleaning over 3d ago", False),
    ],
)
def test_a_moment_of_the_house_is_over_or_under_so_long_ago(text: str, *, is_over: bool) -> None:
    found = read_condition(text)
    assert isinstance(found, SinceMoment)
    assert (found.moment.words, found.seconds, found.is_over) == ("last cleaning", 259_200.0, is_over)


def test_a_message_holds_in_the_run_that_it_started() -> None:
    assert read_condition("message on home/bell with state.action = single") == MessageComes(
        "home/bell", ("state", "action"), "single"
    )
    assert read_condition("not message on home/bell with ''") == MessageComes("home/bell", value="", is_denied=True)
