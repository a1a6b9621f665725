"""The defaults of the app that turns lamps off and of the presence guard: they do turn off, and not over people."""

import pytest
from tests.days.left_on import DEFAULTS, LONG, Family, Score, Trial, scored
from tests.sizes import nightly
from tests.whole_house import WHOLE_HOUSE

MOVES, SITS, READS = Family(0.0), Family(1200.0), Family(3000.0)
READS_WITH_RADARS, READS_WITH_BOTH = Family(3000.0, "presence"), Family(3000.0, "both")


def score_of(people: Family, trial: Trial = DEFAULTS) -> Score:
    ((_, _, score),) = scored(1, (trial,), (people,))
    return score


@WHOLE_HOUSE
@pytest.mark.slow
@pytest.mark.parametrize("people", [READS_WITH_RADARS, *(pytest.param(one, marks=nightly) for one in (MOVES, SITS))])
def test_by_default_lamps_left_on_are_turned_off_and_those_of_people_who_sit_still_are_not(people: Family) -> None:
    """With radars also those of people who sit still for fifty minutes."""
    score = score_of(people)
    assert score.right > (10 if people.sensors == "motion" else 3)
    assert score.precision == 1.0
    assert score.recall == 1.0
    assert max(score.delays) < LONG


@WHOLE_HOUSE
@pytest.mark.slow
@pytest.mark.parametrize("people", [READS_WITH_RADARS, READS_WITH_BOTH])
def test_with_radars_an_app_that_waits_a_minute_is_right_and_soon(people: Family) -> None:
    """Beside motion sensors too, whose twenty minutes it does not wait for."""
    score = score_of(people, Trial(60.0, DEFAULTS.absent_after))
    assert score.precision == score.recall == 1.0
    assert max(score.delays) < 300.0


@nightly
def test_without_radars_lamps_are_turned_off_over_people_who_sit_still_for_fifty_minutes() -> None:
    assert score_of(READS).precision < 0.7


@nightly
def test_half_the_time_turns_lamps_off_over_people_who_sit_still() -> None:
    half = Trial(DEFAULTS.quiet_after / 2, DEFAULTS.absent_after / 2)
    assert score_of(MOVES, half).precision == 1.0
    assert score_of(SITS, half).precision < 0.7
