"""Which candidate is in view is found in rooms with noise, drift, clouds, reflections, and lamps that are late."""

from dataclasses import replace
from random import Random
from statistics import median

import pytest
from tests.features.identify.rooms import Rooms, identify
from tests.sizes import size

from homebot.features.identify.belief import Belief, Seen
from homebot.features.identify.inquiry import Inquiry

ROOMS = size(50, 2000)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "right", "wrong", "seconds"),
    [
        (Rooms(), 0.99, 0.001, 24),
        (Rooms(late=2.0), 0.99, 0.001, 40),
        (Rooms(noise=0.1), 0.99, 0.001, 24),
        (Rooms(reflections=0.5), 0.96, 0.001, 28),
        (Rooms(is_in_view=False), 0.95, 0.001, 40),
        (Rooms(least=0.0), 0.97, 0.001, 27),
        (Rooms(count=3), 0.99, 0.001, 20),
        (Rooms(jump=10.0), 0.97, 0.001, 30),
        (Rooms(count=1), 0.99, 0.001, 20),
        (Rooms(count=1, is_in_view=False), 0.97, 0.001, 20),
        (Rooms(count=1, is_in_view=False, jump=10.0), 0.97, 0.001, 20),
    ],
    ids=[
        *("late", "later", "quiet", "reflections", "none", "unknown", "three"),
        *("jump", "one", "not the one", "not the one, but a jump"),
    ],
)
def test_the_candidate_in_view_is_found(kind: Rooms, right: float, wrong: float, seconds: float) -> None:
    found = [identify(kind, seed) for seed in range(ROOMS)]
    assert sum(one.is_right for one in found) >= right * ROOMS
    assert sum(one.is_wrong for one in found) <= wrong * ROOMS
    assert median(one.seconds for one in found) <= seconds


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind",
    [
        Rooms(twin=1.0),
        Rooms(twin=0.9),
        Rooms(is_announced_twice=True),
        Rooms(is_announced_twice=True, count=2, noise=0.05),
        Rooms(is_announced_twice=True, reports_commands=True),
        Rooms(is_announced_twice=True, reports_commands=True, noise=0.05),
        Rooms(flicker=3.0),
        Rooms(flicker=3.0, is_in_view=False, count=1),
        Rooms(limit=5.3),
        Rooms(limit=5.6),
        Rooms(limit=5.6, reflections=0.5),
        Rooms(limit=6.0),
        Rooms(limit=5.4, noise=0.05, reflections=0.5),
        Rooms(step=2.0),
        Rooms(step=2.0, noise=0.02),
        Rooms(step=5.0),
    ],
    ids=[
        *(
            "twins",
            "nearly twins",
            "one relay",
            "one quiet relay",
            "a relay with two reports",
            "a quiet one",
            "flickers",
            "flickers alone",
            "saturated",
            "at times",
            "by reflections",
            "seldom",
            "and quiet",
        ),
        *("coarse", "coarse and quiet", "very coarse"),
    ],
)
def test_nothing_is_sure_where_two_shine_alike_or_the_sensor_cannot_tell(kind: Rooms) -> None:
    """By the least effect that is supposed if nobody states one."""
    found = [identify(replace(kind, least=0.0), seed) for seed in range(ROOMS // 2)]
    assert sum(one.is_wrong for one in found) == 0
    assert sum(one.is_right for one in found) <= (0.1 * ROOMS if kind.twin or kind.flicker else 0)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.25, 0.5])
@pytest.mark.parametrize("is_in_view", [True, False])
def test_nothing_is_wrong_where_lamps_report_at_once_and_fade_for_long(noise: float, *, is_in_view: bool) -> None:
    kind = Rooms(late=0.0, fade=5.0, noise=noise, is_in_view=is_in_view, least=0.0)
    assert not any(identify(kind, seed).is_wrong for seed in range(ROOMS // 2))


def test_none_is_not_sure_while_a_candidate_may_have_the_stated_effect() -> None:
    """Of 32 lamps with weak reflections, "none" was certain in 5 of 12 rooms where one was in view."""
    assert not any(identify(Rooms(count=32), seed).is_wrong for seed in (0, 1, 5))


def seen(*levels: float, value: float) -> Seen:
    return Seen(levels, value, 0.01, 2.0)


def test_two_that_shine_alike_are_never_told_apart() -> None:
    """Both are in view; nothing is sure, however long it takes, and it is said which."""
    inquiry = Inquiry(3, 2.0, 0.99, Random(1))  # noqa: S311 - a simulation
    for _, code in zip(range(40), inquiry.codes(), strict=False):
        first, second, third = levels = tuple(map(float, code or (True,) * 3))
        inquiry.add(seen(*levels, value=10 + 5 * first + 5 * second + 0.1 * third))
        assert not inquiry.is_sure
    assert inquiry.rivals == [0, 1]


def test_the_effects_are_known_in_the_unit_of_the_sensor() -> None:
    belief = Belief(seen(0, 0, value=100), 10.0, 400.0)
    for first, second in ((1, 0), (1, 1), (0, 1), (0, 0), (1, 1), (0, 1)):
        belief.add(seen(first, second, value=100 + 200 * first + 10 * second))
    effect, deviation = belief.effect(0)
    assert abs(effect - 200) < 3 * deviation < 100


def test_a_candidate_may_be_bright_at_first() -> None:
    inquiry = Inquiry(2, 20.0, 0.99, Random(1))  # noqa: S311 - a simulation
    inquiry.add(seen(1, 1, value=300))
    for code in inquiry.codes():
        first, second = levels = tuple(map(float, code or (True, True)))
        inquiry.add(seen(*levels, value=90 + 200 * first + 10 * second))
    assert inquiry.found == 0
