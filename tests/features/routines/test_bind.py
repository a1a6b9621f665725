"""``homebot bind``, against the services of a real directory with buttons of equal names."""

from functools import partial

import pytest
from tests.announcements import sighting_of
from tests.cli.conftest import NOW, HomebotWith, Run, run_at

from homebot.clock import ManualClock
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest, ChangeRoutineResponse
from homebot.devices.names import CHANGE_ROUTINE
from homebot.devices.part import Capability, Part
from homebot.discovery import DeviceIndex
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.services import DirectoryServices
from homebot.graph import Graph, Node

BUTTONS = {
    "Dimmer": {"up": "Key", "down": "key", "off": "Off"},
    "Bell": {"": ""},
    "bell": {"": ""},
    "Remote": {"1": "One", "2": "Two"},
    "Switch": {"action": "Action", "trigger": "action"},
}


def buttons(graph: Graph) -> Node:
    node, index = Node(graph, "discovery"), DeviceIndex(forget_after=1000.0)
    for number, (name, parts) in enumerate(BUTTONS.items()):
        press = (Capability(name="press", options=("single",)),)
        button = partial(Part, service_type="generic_switch", capabilities=press)
        found = tuple(button(id=part_id, name=label) for part_id, label in parts.items())
        index.observe(sighting_of(f"homeassistant:{number}", *found, name=name, convention="homeassistant",
                                  identifiers=(f"mac:00000000000{number}",), at=NOW), NOW)  # fmt: skip
    persistence = IndexPersistence(node, index, None)
    DirectoryServices(node, index, persistence, lambda at_most: len(index.pop_changes(at_most)) >= at_most).register()
    node.create_service(ChangeRoutine, CHANGE_ROUTINE, written)
    return node


def written(request: ChangeRoutineRequest) -> ChangeRoutineResponse:
    return ChangeRoutineResponse(message=request.text)


@pytest.fixture
def run(homebot_with: HomebotWith, capsys: pytest.CaptureFixture[str]) -> Run:
    return run_at(homebot_with(buttons, ManualClock(NOW)), capsys)


@pytest.mark.parametrize(
    ("button", "choice", "chosen"),
    [
        ("Dimmer", "'Dimmer#up', 'Dimmer#down', 'Dimmer#Off'", "Dimmer#down"),
        ("Dimmer#key", "'Dimmer#up', 'Dimmer#down'", "Dimmer#up"),
        ("Remote", "'Remote#One', 'Remote#Two'", "Remote#two"),
        ("Switch", "'Switch#action', 'Switch#trigger'", "Switch#action"),
        ("Bell", """'id="bell"', 'id="bell_0002"'""", 'id="bell"'),
        ("Bell", "", "bell_0002"),
    ],
)
def test_a_choice_between_buttons_names_equal_ones_by_ids_which_are_taken(
    run: Run, button: str, choice: str, chosen: str
) -> None:
    code, said = run("bind", button, "single", "lamp", "toggle")
    assert code > 0
    assert f"name one of {choice}" in said
    code, said = run("bind", chosen, "single", "lamp", "toggle")
    assert (code, f"{chosen} press single" in said.replace("\\", "")) == (0, True), said
