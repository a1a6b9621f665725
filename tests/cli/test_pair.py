"""``homebot pair`` finds the gateway of a device, and shows what it answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from tests.cli.conftest import Homebot
from tests.cli.test_places import NOW, sighting
from tests.gateways.test_pairing import CODE, Bulbs

from homebot.cli import main
from homebot.clock import Clock, ManualClock
from homebot.discovery import DeviceIndex
from homebot.discovery.persistence import IndexPersistence
from homebot.discovery.services import DirectoryServices
from homebot.gateways.pairing import PairingServices
from homebot.graph import Graph, Node

Run = Callable[..., tuple[int, str]]


def index_node(graph: Graph) -> Node:
    """A directory with a lamp of a gateway that pairs, and one of a gateway that does not."""
    node = Node(graph, "discovery")
    index = DeviceIndex(forget_after=1000.0)
    bulb = {"gateway": "bulbs", "key": "one", "convention": ""}
    index.observe(sighting(0, "Bulb", "").model_copy(update=bulb), NOW)
    index.observe(sighting(1, "Lamp", ""), NOW)
    persistence = IndexPersistence(node, index, None)
    DirectoryServices(node, index, persistence, lambda at_most: len(index.pop_changes(at_most)) >= at_most).register()
    PairingServices(Bulbs(), Node(graph, "bulbs", namespace="/gateway"))
    return node


@pytest.fixture
def run(homebot_with: Callable[[Callable[[Graph], Node], Clock], Any], capsys: pytest.CaptureFixture[str]) -> Run:
    made: Homebot = homebot_with(index_node, ManualClock(NOW))

    def homebot(*arguments: str) -> tuple[int, str]:
        code = main(["--door", made.door, *arguments])
        out, err = capsys.readouterr()
        return code, out + err

    return homebot


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
