from pathlib import Path

import pytest

import homebot.house
from homebot.house import office_world

HOME = Path(homebot.house.__file__).parent / "office" / "home.toml"


@pytest.mark.house("office:Office", world=office_world, root="office", config=HOME)
async def test_robots_change_floors_one_after_the_other_and_one_that_dies_in_the_lift_frees_it(house):
    await house.run_for("3m")
    happened = [f"{event.who} {event.verb} {event.what}" for event in house.world.event_log.since(0)]
    first, second = sorted(("robot", "rosie"), key=lambda robot: happened.index(f"{robot} told go lift"))
    steps = [
        "workshop_door says unlocked",
        f"{first} told go lobby",
        "lift says open",
        f"{first} told go lift",
        "lift says closed",
        "lift told upper",
        "lift says upper",
        "lift says open",
        f"{first} told go landing",
        f"{first} says landing",
        "lift says closed",
        "lift told ground",
        "lift says ground",
        "lift says open",
        f"{second} told go lift",
        "lift says open",
        f"{second} says landing",
        "bob told go lift",
        "bob says lift",
        "lift told close",
        "lift says closed",
    ]
    rest = iter(happened)
    assert [step for step in steps if step not in rest] == []
    assert {f"{robot} says lab" for robot in (first, second)} <= {*happened}
    assert "workshop_door says locked" in happened[happened.index("bob says lobby") :]
