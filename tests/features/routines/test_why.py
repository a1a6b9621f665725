"""``homebot why``: the routines that sent a robot."""

from typing import cast

from homebot.cli.door_client import DoorClient
from homebot.devices.app_messages import RoutineInfo, RoutineNote, RoutinesResponse
from homebot.features.routines.why import sent_robot
from homebot.messages import Time
from homebot.messages.json import message_to_json


class Door:
    """A homebot with two routines."""

    def __init__(self, **notes: list[tuple[int, str]]) -> None:
        infos = [
            RoutineInfo(
                name=name,
                app=name,
                notes=tuple(RoutineNote(at=Time(sec=at, nanosec=0), text=text) for at, text in told),
            )
            for name, told in notes.items()
        ]
        self._answer = RoutinesResponse(routines=tuple(infos))

    def call(self, service: str, request: dict[str, object] | None = None) -> object:
        assert not request
        return message_to_json(self._answer) if service == "/routines/list" else {"time": {"sec": 20, "nanosec": 0}}


def test_the_outcomes_of_the_steps_for_a_robot_are_told_oldest_first() -> None:
    door = Door(
        away=[(5, "ran"), (9, "'rosie go to kitchen' failed: it is locked"), (10, "done: 'Rosie drives to dock'")],
        home=[
            (7, "done: 'rosie go to hall'"),
            (8, "done: 'rosie2 go to hall'"),
            (11, "held back: not 'rosie in hall'"),
        ],
    )
    assert [line.partition(" s ago")[0] for line in sent_robot(cast("DoorClient", door), "Rosie")] == [
        "The routine home: done: 'rosie go to hall', 13",
        "The routine away: 'rosie go to kitchen' failed: it is locked, 11",
        "The routine away: done: 'Rosie drives to dock', 10",
    ]
