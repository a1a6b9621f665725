"""The defaults of the app that turns lamps off and of the presence guard: they do turn off, and not over people."""

from tests.days.left_on import DEFAULTS, LONG, Score, Trial, scored
from tests.sizes import nightly


def scores(trial: Trial) -> dict[str, Score]:
    return {people: score for people, _, score in scored(1, (trial,))}


@nightly
def test_by_default_lamps_left_on_are_turned_off_and_those_of_people_who_sit_still_are_not() -> None:
    for score in scores(DEFAULTS).values():
        assert score.right > 10
        assert score.precision == 1.0
        assert score.recall == 1.0
        assert max(score.delays) < LONG


@nightly
def test_half_the_time_turns_lamps_off_over_people_who_sit_still() -> None:
    found = scores(Trial(DEFAULTS.quiet_after / 2, DEFAULTS.absent_after / 2))
    assert found["forgetful"].precision == 1.0
    assert found["forgetful, sit still"].precision < 0.7
