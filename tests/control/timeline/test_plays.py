"""Who did what in plays of groups, fades, blinds, timers, programs, power cuts and restarts, against a known truth."""

import pytest
from tests.control.timeline.plays_table import PLAYS, score_of
from tests.sizes import size


@pytest.mark.parametrize("name", PLAYS)
def test_homebot_knows_who_did_it(name: str) -> None:
    score = score_of(name, range(size(1, 10)))
    assert score.asked
    assert not PLAYS[name].missed(score), score.failures[:5]
