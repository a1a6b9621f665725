"""``homebot action`` and ``homebot param``, and the types of topics and services: what they print, letter by letter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import pytest

from homebot.cli import main
from homebot.clock import ManualClock
from homebot.graph import Graph, Node, ParameterDescriptor
from homebot.graph.actions import ActionServer, ServerGoal
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message

if TYPE_CHECKING:
    from tests.cli.conftest import Homebot

Text = pytest.CaptureFixture[str]
FIBONACCI = find_action("example_interfaces/action/Fibonacci")

DUMP = """\
/robot:
  ros__parameters:
    arm.joints:
      - shoulder
      - elbow
    arm.reach: 0.8
    speed: 0.5
    steps: 3
"""


def robot(graph: Graph) -> Node:
    """A node with parameters and an action; a goal of more than 90 ends aborted."""
    node = Node(graph, "robot")
    node.declare_parameter("speed", 0.5, ParameterDescriptor("Metres per second.", minimum=0.0, maximum=2.0))
    node.declare_parameter("steps", 3, ParameterDescriptor(read_only=True))
    node.declare_parameter("arm.reach", 0.8, ParameterDescriptor(minimum=0.1))
    node.declare_parameter("arm.joints", ("shoulder", "elbow"))

    async def execute(goal: ServerGoal[Any, Any, Any]) -> Message:
        sequence = [0, 1]
        while len(sequence) <= goal.request.order < 90:
            sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(FIBONACCI.Feedback(sequence=sequence))
            await anyio.sleep(0.02)  # as an arm moves
        (goal.succeed if goal.request.order < 90 else goal.abort)()
        result: Message = FIBONACCI.Result(sequence=sequence)
        return result

    ActionServer(node, FIBONACCI, "fibonacci", execute)
    return node


@pytest.fixture
def door(homebot_with: Any) -> str:
    homebot: Homebot = homebot_with(robot, ManualClock(1_700_000_000))
    return homebot.door


@pytest.mark.parametrize(
    ("arguments", "printed"),
    [
        ("param list", "/robot:\n  arm.joints\n  arm.reach\n  speed\n  steps\n"),
        ("param get robot speed", "Double value is: 0.5\n"),
        ("param get /robot arm.joints", "String values are: ['shoulder', 'elbow']\n"),
        ("param set /robot speed 1", "Set parameter successful\n"),
        (
            "param describe /robot speed",
            "Parameter name: speed\n  Type: double\n  Description: Metres per second.\n  Constraints:\n"
            "    Min value: 0.0\n    Max value: 2.0\n    Read only: false\n",
        ),
        (
            "param describe /robot arm.reach",
            "Parameter name: arm.reach\n  Type: double\n  Constraints:\n    Additional constraints: at least 0.1\n"
            "    Read only: false\n",
        ),
        ("param dump /robot", DUMP),
        ("action list", "/fibonacci\n"),
        ("action list -t", "/fibonacci [example_interfaces/action/Fibonacci]\n"),
        ("action info fibonacci", "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n    /robot\n"),
        (
            "action send_goal /fibonacci {order: 3}",
            "Sending goal:\n    order: 3\n\nResult:\n    sequence: [0, 1, 1, 2]\n\n"
            "Goal finished with status: SUCCEEDED\n",
        ),
        (
            "action send_goal -f /fibonacci example_interfaces/Fibonacci {order: 2}",
            "Sending goal:\n    order: 2\n\nFeedback:\n    sequence: [0, 1, 1]\n\nResult:\n    sequence: [0, 1, 1]\n\n"
            "Goal finished with status: SUCCEEDED\n",
        ),
        ("topic type /hello", "std_msgs/msg/String\n"),
        ("topic find std_msgs/String", "/chatter\n/hello\n"),
        ("service type /rosapi/get_time", "rosapi_msgs/srv/GetTime\n"),
        ("service find rosapi_msgs/srv/GetTime", "/rosapi/get_time\n"),
    ],
)
def test_a_command_prints_what_it_should(door: str, capsys: Text, arguments: str, printed: str) -> None:
    assert main(["--door", door, *split(arguments)]) == 0
    assert capsys.readouterr().out == printed


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ("param get /robot sped", "/robot has no parameter sped; did you mean speed?"),
        ("param get /robto speed", "/robto has no parameters; `homebot param list` lists all that have"),
        ("param set /robot speed 3", "/robot refused it: /robot: parameter 'speed' must be from 0 to 2, got 3.0"),
        ("param set /robot steps 4", "/robot refused it: /robot: parameter 'steps' is read-only"),
        (
            "param set /robot speed fast",
            "/robot refused it: /robot: parameter 'speed' is of type double, got the string 'fast'",
        ),
        (
            "param set /robot speed {a: 1}",
            "speed: a parameter is a bool, number, text, or a list of one of these, got {'a': 1}",
        ),
        ("action info /fibonaci", "there is no action /fibonaci; did you mean /fibonacci?"),
        (
            "action send_goal /fibonacci std_msgs/Empty {}",
            "action /fibonacci is a example_interfaces/action/Fibonacci, not a std_msgs/Empty",
        ),
        ("topic type /helo", "there is no topic /helo; did you mean /hello?"),
        ("topic find std_msgs/Sting", "there is no topic of type std_msgs/Sting; did you mean std_msgs/msg/String?"),
        ("service type /zzzz", "there is no service /zzzz; `homebot service list` lists all"),
    ],
)
def test_a_command_that_cannot_be_done_says_why(door: str, capsys: Text, arguments: str, problem: str) -> None:
    assert main(["--door", door, *split(arguments)]) == 1
    assert capsys.readouterr().err == f"homebot: {problem}\n"


def test_a_goal_that_is_aborted_is_a_failure(door: str, capsys: Text) -> None:
    assert main(["--door", door, *split("action send_goal /fibonacci {order: 90}")]) == 1
    out, err = capsys.readouterr()
    assert "Result:\n    sequence: [0, 1]\n" in out
    assert err == "Goal finished with status: ABORTED\n"


def test_parameters_of_a_file_are_set_one_by_one(door: str, capsys: Text, tmp_path: Path) -> None:
    """A dump, with a changed value: only the read-only one is refused. Those for all nodes come first."""
    file = tmp_path / "robot.yaml"
    file.write_text(DUMP.replace("0.5", "1.5").replace("arm.reach: 0.8", "arm: {reach: 0.9}") + everywhere)
    assert main(["--door", door, "param", "load", "/robot", str(file)]) == 1
    assert capsys.readouterr().out == (
        "Set parameter arm.joints successful\n"
        "Set parameter arm.reach successful\n"
        "Set parameter speed successful\n"
        "Set parameter steps failed: /robot: parameter 'steps' is read-only\n"
    )
    assert main(["--door", door, *split("param dump /robot")]) == 0
    assert capsys.readouterr().out == DUMP.replace("0.5", "1.5").replace("0.8", "0.9")


everywhere = """\
# for all
/**:
  ros__parameters:
    speed: 1.5
"""


def split(arguments: str) -> list[str]:
    """Return the words of *arguments*; what begins with a brace is one."""
    head, brace, rest = arguments.partition("{")
    return [*head.split(), *([brace + rest] if brace else [])]
