"""``homebot pair`` finds the gateway of a device, and shows what it answers."""

from collections.abc import Callable

import pytest
from tests.cli.conftest import NOW, Run
from tests.cli.test_places import index_node, sighting
from tests.gateways.test_pairing import CODE, Bulbs

from homebot.discovery import DeviceIndex
from homebot.gateways.pairing import PairingServices
from homebot.graph import Graph, Node


def home(graph: Graph) -> Node:
    """A directory with a lamp of a gateway that pairs, and one of a gateway that does not."""
    index = DeviceIndex(forget_after=1000.0)
    bulb = {"gateway": "bulbs", "key": "one", "convention": ""}
    index.observe(sighting(0, "Bulb", "").model_copy(update=bulb), NOW)
    index.observe(sighting(1, "Lamp", ""), NOW)
    PairingServices(Bulbs(), Node(graph, "bulbs", namespace="/gateway"))
    return index_node(index, graph, ())


@pytest.fixture
def run(run_with: Callable[..., Run]) -> Run:
    return run_with(home)


def test_a_device_is_paired_and_unpaired(run: Run) -> None:
    assert run("pair", "Bulb", CODE) == (0, "Bulb one is paired\n")
    assert run("pair", "--remove", "bulb") == (0, "Bulb one is not paired any more\n")


def test_a_wrong_code_is_told_and_not_shown(run: Run) -> None:
    code, text = run("pair", "Bulb", "111-11-111")
    assert (code, "the code is wrong" in text, "111-11" in text) == (1, True, False)


def test_a_device_without_pairing_says_so(run: Run) -> None:
    code, text = run("pair", "Lamp", CODE)
    assert code == 1
    assert "lamp needs no pairing" in text


def test_removing_takes_no_code(run: Run) -> None:
    code, text = run("pair", "--remove", "Bulb", CODE)
    assert (code, "--remove takes no code" in text) == (1, True)
