"""The plan of a house in a terminal."""

import pytest

from homebot.cli.house_picture import PlanPicture

PLAN = PlanPicture(
    {"kitchen": (-5.0, 2.0, 5.0, 7.0), "study": (5.0, 2.0, 15.0, 7.0), "hall": (-5.0, -1.0, 15.0, 2.0)},
    [(0.0, 2.0)],
    1.0,
)


def drawn(plan: PlanPicture, width: int, height: int) -> list[str]:
    return ["".join(text for text, _ in line) for line in plan.lines({"hall": "☺▣"}, {"study"}, width, height)]


def test_rooms_have_their_walls_doors_and_beings() -> None:
    assert drawn(PLAN, 41, 5) == [
        "┌───────────────────┬───────────────────┐",
        "│ kitchen           │ study             │",
        "├────────   ────────┴───────────────────┤",
        "│ hall ☺▣                               │",
        "└───────────────────────────────────────┘",
    ]


def test_a_door_in_a_side_wall_is_one_line_high() -> None:
    plan = PLAN._replace(doors=[(5.0, 4.5)])
    assert drawn(plan, 41, 5)[:3] == [
        "┌───────────────────┬───────────────────┐",
        "│ kitchen             study             │",
        "├───────────────────┴───────────────────┤",
    ]


def test_a_room_with_light_stands_out() -> None:
    styles = {text.strip(): style for line in PLAN.lines({}, {"study"}, 41, 5) for text, style in line}
    assert (styles["study"], styles["hall"]) == ("yellow", "dim")


@pytest.mark.parametrize(("width", "height"), [(41, 4), (12, 9)])
def test_without_space_for_each_name_there_is_no_plan(width: int, height: int) -> None:
    assert drawn(PLAN, width, height) == []


def test_a_house_without_extents_has_no_plan() -> None:
    assert drawn(PlanPicture({}, [], 1.0), 100, 9) == []
