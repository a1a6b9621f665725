"""Whose doing each change in a house was, against a simulated truth: groups, scenes, timers, late answers, persons.

The table is printed with ``pytest -s``.
"""

from random import Random

import pytest
from tests.control.conftest import OpenHome
from tests.control.timeline.simulated_house import SimulatedHouse, Tables
from tests.control.timeline.simulated_kinds import KINDS, Kind, Play
from tests.one_task import in_one_task
from tests.sizes import size

pytestmark = pytest.mark.virtual_time

_TABLES = Tables()


def furnish(house: SimulatedHouse) -> None:
    """Put some of each kind into rooms of their own."""
    choose = house.random
    house.group("ceiling", "hall", 3, is_listed=True)
    house.group("spots", "kitchen", 3, is_listed=False)
    house.scene("evening", "living", 3, is_listed=True)
    house.scene("reading", "study", 2, is_listed=False)
    house.mirrored("plug", "office")
    house.timer("stairs", "stairs", choose.uniform(20.0, 120.0))
    house.timer("boiler", "cellar", choose.uniform(120.0, 600.0))
    for number in range(3):
        house.late(f"valve{number}", f"bath{number}")
    for number in range(3):
        house.commanded(f"lamp{number}", f"room{number}")
    house.slow("porch", "porch")


@pytest.fixture
async def tables(open_home: OpenHome) -> Tables:
    """Live in some houses, once."""
    if not _TABLES.commands:
        for seed in range(size(2, 40)):
            async with in_one_task(open_home(rate_limit=False, always_ask=False)) as home:
                house = SimulatedHouse(home, Random(seed), _TABLES)  # noqa: S311 - no secrets
                furnish(house)
                await house.run()
        print(_TABLES.text())  # noqa: T201 - the table is the result
    return _TABLES


async def test_what_comes_along_with_a_command_is_no_person(tables: Tables) -> None:
    assert tables.count(truth="along", told="person") == 0
    for kind in ("member", "lamp of a scene"):
        assert tables.share("along", "command", kind) == 1.0
    for kind in ("unlisted member", "mirrored"):
        assert tables.share("along", "command", kind) >= 0.8


async def test_nobody_is_blamed_on_a_device_or_overridden(tables: Tables) -> None:
    assert tables.count(truth="person", told="device") == 0
    assert not tables.overridden


async def test_persons_are_named_and_hardly_anything_else_is_told_to_be_one(tables: Tables) -> None:
    assert tables.share("person", "person") >= 0.8
    assert tables.wrong_persons <= 0.03


async def test_a_timer_is_learnt_and_an_answer_may_come_after_minutes(tables: Tables) -> None:
    assert tables.share("device", "device") >= 0.6
    assert tables.share("command", "command", "late") == 1.0


@pytest.mark.parametrize("kind", [pytest.param(kind, id=kind.name) for kind in KINDS])
async def test_the_aims_of_each_kind_are_met_and_all_who_are_asked_give_one_answer(
    open_home: OpenHome, kind: Kind
) -> None:
    tables = await Play(kind, seed=0).run(open_home)
    assert tables.seen["asked"] > 10
    assert kind.failures(tables, seeds=1) == [], "\n".join(tables.notes)
