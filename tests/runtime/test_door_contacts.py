"""The contacts that the presence guard is told of must be on every door of the room in the plan."""

from __future__ import annotations

import pytest

from homebot.config import parse_config
from homebot.errors import ConfigError
from homebot.runtime.plan import make_plan, plan_errors

ROOMS: dict[str, object] = {"bath": {}, "hall": {"doors": ["bath", "outside"]}}


def config(doors: dict[str, list[str]], rooms: dict[str, object] = ROOMS) -> dict[str, object]:
    return {"places": {"rooms": rooms}, "control": {"presence_guard": {"doors": doors}}}


@pytest.mark.parametrize(
    ("doors", "rooms"),
    [({"Bath": ["Bath door"], "hall": ["Bath door", "Front door"]}, ROOMS), ({"attic": ["Hatch"]}, {})],
)
def test_every_door_may_have_a_contact(doors: dict[str, list[str]], rooms: dict[str, object]) -> None:
    """Without a plan nothing is known of doors."""
    plan = make_plan(parse_config(config(doors, rooms), "homebot.toml"))
    assert plan.control is not None
    assert plan.control.presence_guard is not None
    assert {name: list(ids) for name, ids in plan.control.presence_guard.doors.items()} == doors


@pytest.mark.parametrize(
    ("doors", "key", "problem"),
    [
        ({"bth": ["Bath door"]}, "control.presence_guard.doors.bth", "there is no room 'bth'; did you mean bath?"),
        (
            {"hall": ["Front door"]},
            "control.presence_guard.doors.hall",
            "hall has 2 doors (to bath, outside), and only 1 of them a contact; it takes one on each",
        ),
        ({"bath": []}, "control.presence_guard.doors.bath", "should have at least 1 item"),
    ],
)
def test_a_door_without_a_contact_is_an_error(doors: dict[str, list[str]], key: str, problem: str) -> None:
    """Somebody may leave by it."""
    with pytest.raises(ConfigError) as raised:
        make_plan(parse_config(config(doors), "homebot.toml"))
    assert raised.value.key == key
    assert problem in str(raised.value)


def test_a_wrong_plan_is_told_once() -> None:
    wrong = config({"bath": ["Bath door"]}, {"bath": {"doors": ["attic"]}})
    (error,) = plan_errors(parse_config(wrong, "homebot.toml"))
    assert error.key == "places.rooms.bath.doors"
