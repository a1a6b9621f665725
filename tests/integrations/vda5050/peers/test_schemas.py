"""What homebot sends to a robot of VDA 5050, and what the simulated one says, by the schemas of the standard."""

import json
import subprocess

import pytest
from tests.integrations.vda5050.robot import FleetRobot
from tests.integrations.vda5050.test_vda5050 import Fleet, convention
from tests.peers.other_python import python_with

from homebot.conventions.description import DeviceRequest, Publication

CHECK = """
import json
import sys

from vda5050.validation import SchemaValidator

for kind, message in json.load(sys.stdin):
    print(kind, *SchemaValidator().errors(kind, message), sep="; ")
"""


@pytest.fixture(scope="module")
def python() -> str:
    return python_with("vda5050-sdk", "3.13", "3.12", "3.11")


def problems(python: str, *said: Publication) -> list[str]:
    """Return the kind of each message, with what the schema of version 2.1 finds in it."""
    messages = [(one.topic.rpartition("/")[2], json.loads(one.payload)) for one in said]
    done = subprocess.run(
        [python, "-c", CHECK], input=json.dumps(messages), capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.split("\n")[:-1]


def test_what_the_simulated_robot_says_is_valid(python: str) -> None:
    robot = FleetRobot()
    said = robot.connection(), robot.last_will, robot.state()
    assert problems(python, *said) == ["connection", "connection", "state"]


def test_orders_and_instant_actions_are_valid(python: str) -> None:
    fleet = Fleet(FleetRobot(node="Hall"), charger="dock")
    (_, asked) = convention().read_message(*fleet.robot.connection()[:2], retained=True)
    assert isinstance(asked, DeviceRequest)
    sent: list[Publication] = [*asked.publications]
    for value, part in (("charging", ""), ("idle", ""), ("lift", "destination"), ("paused", ""), ("working", "")):
        fleet.read()
        sent += fleet.command(value, part)
    assert problems(python, *sent) == [
        "instantActions",
        "order",
        "instantActions",
        "order",
        "instantActions",
        "instantActions",
    ]


def test_the_schemas_find_what_is_wrong(python: str) -> None:
    (found,) = problems(python, Publication("uagv/v2/KIT/0001/order", b'{"orderId": 7}'))
    assert "headerId" in found
