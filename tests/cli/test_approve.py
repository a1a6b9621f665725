"""``homebot approve``, and what the other commands tell of devices that wait, against a real directory and control."""

import json
from collections.abc import Callable

import pytest
from tests.cli.conftest import NOW, Run
from tests.cli.test_places import index_node, sighting

from homebot.control import Control
from homebot.devices.part import Capability, Part
from homebot.discovery import DeviceIndex
from homebot.graph import Graph, Node


def home(graph: Graph) -> Node:
    """A directory with a lamp, a lock and a double switch, and the control layer's services that are asked here."""
    index = DeviceIndex(forget_after=1000.0)
    capability = Capability(name="lock", settable=True)
    lock = Part(id="l", service_type="door_lock", capabilities=(capability,), writes=("door/set",))
    index.observe(sighting(0, "Lamp", ""), NOW)
    index.observe(sighting(1, "Front door", "Hall").model_copy(update={"parts": (lock,)}), NOW)
    gangs = tuple(
        Part(id=side, service_type="switch", capabilities=(Capability(name="on_off", settable=True),))
        for side in ("left", "right")
    )
    index.observe(sighting(2, "Double switch", "Hall").model_copy(update={"parts": gangs}), NOW)
    Control(Node(graph, "control")).register()
    return index_node(index, graph, ())


@pytest.fixture
def run(run_with: Callable[..., Run]) -> Run:
    """Runs a command, and returns its exit code and what it printed, each run of spaces as one."""
    command = run_with(home)

    def run(*arguments: str) -> tuple[int, str]:
        code, printed = command(*arguments)
        return code, "\n".join(" ".join(line.split()) for line in printed.splitlines())

    return run


def approved(text: str) -> dict[str, object]:
    return {one["id"]: one["approved"] for one in json.loads(text)}


def test_what_is_not_harmless_says_why_until_the_owner_says_that_it_is(run: Run) -> None:
    why = "nothing but its name says what this switch turns on"
    change = "if it can hurt nobody, homebot tag add 'Double switch' harmless"
    assert f"not harmless left: {why}; right: {why}; {change}" in run("show", "Double switch")[1]
    run("tag", "add", "Double switch", "harmless")
    assert "not harmless" not in run("show", "Double switch")[1]


def test_a_lock_waits_until_it_is_approved(run: Run) -> None:
    waits = "approval missing: it is dangerous, and gets no commands before `homebot approve DEVICE`"
    note = "note on control: 1 device waits for approval, and nothing is sent before"
    _, listed = run("devices")
    assert "front_door Front door door_lock Hall unknown fresh, unapproved" in listed
    assert listed.count("unapproved") == 1
    assert waits in run("show", "Front door")[1]
    assert "always asks it is a door lock" in run("show", "Front door")[1]
    assert waits not in run("show", "Lamp")[1]
    assert "always asks" not in run("show", "Lamp")[1]
    assert "not harmless" not in run("show", "Front door")[1] + run("show", "Lamp")[1]
    assert f"{note} (`homebot approve DEVICE`): front_door (it is a door lock)" in run("doctor")[1]
    assert "front_door" in run("find", "unapproved")[1]
    assert "lamp" not in run("find", "unapproved")[1]
    assert approved(run("devices", "--json")[1]) == {"front_door": False, "lamp": None, "double_switch": None}
    assert approved(run("find", "--json", "lock")[1]) == {"front_door": False}
    assert approved(f"[{run('show', '--json', 'Front door')[1]}]") == {"front_door": False}
    assert run("approve", "front door", "--show") == (
        0,
        "front_door waits for approval; its commands:\nl: lock to door/set",
    )
    assert approved(run("find", "--json", "lock")[1]) == {"front_door": False}
    assert run("approve", "front door") == (0, "front_door is approved\nl: lock to door/set")
    assert "front_door does not wait for approval" in run("approve", "front door", "--show")[1]
    assert run("approve", "front door") == (
        0,
        "front_door is approved; it was not waiting for that\nl: lock to door/set",
    )
    assert "unapproved" not in run("devices")[1]
    _, shown = run("show", "Front door")
    assert waits not in shown
    assert "always asks it is a door lock" in shown
    assert "approved yes by the owner now" in shown
    assert note not in run("doctor")[1]
    assert approved(run("devices", "--json")[1]) == {"front_door": True, "lamp": None, "double_switch": None}
    assert run("find", "unapproved")[0] == 1
    assert run("approve", "front door", "--undo") == (0, "front_door is not approved any more")
    assert waits in run("show", "Front door")[1]


def test_a_device_that_is_not_there_cannot_be_approved(run: Run) -> None:
    code, problem = run("approve", "Back door")
    assert code != 0
    assert "there is no device Back door" in problem
