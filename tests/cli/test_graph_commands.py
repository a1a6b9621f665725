"""``homebot action`` and ``homebot param``: what they print, letter by letter."""

import os
import signal
from typing import Any

import anyio
import pytest
from tests.cli.conftest import Homebot

from homebot.cli import main
from homebot.clock import ManualClock
from homebot.graph import EntityKind, Graph, Node, ParameterDescriptor
from homebot.graph.actions import ActionServer, ServerGoal
from homebot.graph.endpoint import EndpointInfo
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message

Text = pytest.CaptureFixture[str]
FIBONACCI = find_action("example_interfaces/action/Fibonacci")

ELSEWHERE = (
    EndpointInfo(EntityKind.NODE, "/rosie/brain", "/rosie/brain"),
    EndpointInfo(EntityKind.PUBLISHER, "/rosie/brain", "/rosie/words", "std_msgs/msg/String"),
    EndpointInfo(EntityKind.SUBSCRIPTION, "/rosie/brain", "/hello", "std_msgs/msg/String"),
    EndpointInfo(EntityKind.SERVICE, "/rosie/brain", "/rosie/dock", "std_srvs/srv/Trigger"),
    EndpointInfo(
        EntityKind.SERVICE,
        "/rosie/brain",
        "/rosie/fibonacci/_action/send_goal",
        "example_interfaces/action/Fibonacci_SendGoal",
    ),
)
"""The entities of a robot, as a link shows them."""

READ_ONLY = (
    "/robot: parameter 'steps' is read-only; set it before its node starts; settings of gateways and apps are in "
    "homebot.toml"
)


def robot(graph: Graph) -> Node:
    """A node with parameters and an action; a goal of 90 ends aborted; during one of 80 Ctrl-C is pressed."""
    node = Node(graph, "robot")
    node.declare_parameter("speed", 0.5, ParameterDescriptor("Metres per second.", minimum=0.0, maximum=2.0))
    node.declare_parameter("speed.limit", 2.0)
    node.declare_parameter("steps", 3, ParameterDescriptor(read_only=True))
    node.declare_parameter("arm.reach", 0.8, ParameterDescriptor(minimum=0.1))
    node.declare_parameter("arm.joints", ("shoulder", "elbow"))

    async def execute(goal: ServerGoal[Any, Any, Any]) -> Message:
        sequence = [0, 1]
        while len(sequence) <= goal.request.order < 90:
            sequence.append(sequence[-1] + sequence[-2])
            goal.publish_feedback(FIBONACCI.Feedback(sequence=sequence))
            if goal.request.order == 80 and len(sequence) == 4:
                os.kill(os.getpid(), signal.SIGINT)
            await anyio.sleep(0.02)  # as an arm moves
        (goal.succeed if goal.request.order < 90 else goal.abort)()
        result: Message = FIBONACCI.Result(sequence=sequence)
        return result

    ActionServer(node, FIBONACCI, "fibonacci", execute)
    for info in ELSEWHERE:
        graph.elsewhere.add(info, info)
    graph.add_endpoint(ELSEWHERE[0], ELSEWHERE[0])
    return node


@pytest.fixture
def door(homebot_with: Any) -> str:
    homebot: Homebot = homebot_with(robot, ManualClock(1_700_000_000))
    return homebot.door


@pytest.mark.parametrize(
    ("arguments", "printed"),
    [
        ("param list", "/robot:\n  arm.joints\n  arm.reach\n  speed\n  speed.limit\n  steps\n"),
        ("param get robot speed", "0.5\n"),
        ("param get /robot arm.joints", "- shoulder\n- elbow\n"),
        ("param set /robot speed 1", "speed is 1\n"),
        ("action list", "/fibonacci\n/rosie/fibonacci  (at /rosie/brain)\n"),
        (
            "action list -t",
            "/fibonacci [example_interfaces/action/Fibonacci]\n"
            "/rosie/fibonacci [example_interfaces/action/Fibonacci]  (at /rosie/brain)\n",
        ),
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
    ],
)
def test_a_command_prints_what_it_should(door: str, capsys: Text, arguments: str, printed: str) -> None:
    assert main(["--door", door, *split(arguments)]) == 0
    assert capsys.readouterr().out == printed


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (
            "param get /robot sped",
            "/robot: no parameter 'sped' is declared; did you mean speed?",
        ),
        (
            "param get /robot power",
            "/robot: no parameter 'power' is declared; declared: arm.joints, arm.reach, speed, speed.limit, steps",
        ),
        ("param get /robto speed", "there is no node '/robto'; did you mean /robot?"),
        ("param list /robto", "/robto has no parameters; did you mean /robot?"),
        ("param set /robot speed 3", "/robot: parameter 'speed' must be from 0 to 2, got 3.0"),
        ("param set /robot steps 4", READ_ONLY),
        (
            "param set /robot speed fast",
            "/robot: parameter 'speed' is of type double, got the string 'fast'",
        ),
        (
            "param set /robot speed {a: 1}",
            "{'a': 1} cannot be a parameter's value",
        ),
        ("action send_goal /fibonaci", "there is no action /fibonaci; did you mean /fibonacci?"),
        (
            "action send_goal /fibonacci std_msgs/Empty {}",
            "action /fibonacci is a example_interfaces/action/Fibonacci, not a std_msgs/Empty",
        ),
        ("service call /zzzz", "there is no service /zzzz; `homebot service list` lists all"),
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


def test_ctrl_c_cancels_a_goal_and_shows_how_it_ended(door: str, capsys: Text) -> None:
    assert main(["--door", door, *split("action send_goal /fibonacci {order: 80}")]) == 130
    out, err = capsys.readouterr()
    assert out == "Sending goal:\n    order: 80\n\nResult:\n    sequence: []\n\n"
    assert err == "Cancelling the goal; its end is awaited for 5 s\nGoal finished with status: CANCELED\n"


def split(arguments: str) -> list[str]:
    """Return the words of *arguments*; what begins with a brace is one."""
    head, brace, rest = arguments.partition("{")
    return [*head.split(), *([brace + rest] if brace else [])]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("node list", "/rosie/brain  (elsewhere)"),
        ("topic list", "/rosie/words  (at /rosie/brain)"),
        ("service list -t", "/rosie/dock [std_srvs/srv/Trigger]  (at /rosie/brain)"),
    ],
)
def test_what_is_of_a_robot_is_listed_with_where_it_is(door: str, capsys: Text, arguments: str, line: str) -> None:
    assert main(["--door", door, *arguments.split()]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert line in lines
    assert lines == sorted(lines)
    assert not any("_action" in one for one in lines)
