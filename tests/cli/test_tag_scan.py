"""``homebot tag scan``, with a gateway without a reader and a real directory."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest
from tests.cli.test_places import NOW, index_node, sighting

from homebot.cli import main
from homebot.clock import Clock, ManualClock
from homebot.discovery import DeviceIndex
from homebot.gateways import GatewayContext
from homebot.gateways.nfc import NfcGateway
from homebot.gateways.nfc.reader import TagReaders
from homebot.graph import Graph, Node

if TYPE_CHECKING:
    from tests.cli.conftest import Homebot

Run = Callable[..., tuple[int, str]]


def home(graph: Graph) -> Node:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(sighting(5, "Shelf lamp", ""), NOW)
    node = Node(graph, "nfc", namespace="/gateway")
    node.create_task(NfcGateway(node, context=GatewayContext.of(TagReaders(()))).serve)
    return index_node(index, graph)


@pytest.fixture
def run(homebot_with: Callable[[Callable[[Graph], Node], Clock], Any], capsys: pytest.CaptureFixture[str]) -> Run:
    made: Homebot = homebot_with(home, ManualClock(NOW))

    def homebot(*arguments: str) -> tuple[int, str]:
        code = main(["--door", made.door, *arguments])
        out, err = capsys.readouterr()
        return code, out + err

    return homebot


def test_a_code_says_which_device_is_meant_and_can_teach_its_room(run: Run) -> None:
    code = "Shelf lamp\narea: Attic"
    told = "it points to Shelf lamp\n  device: shelf_lamp\n  area: Attic\n"
    assert run("tag", "scan", code) == (0, told)
    assert "Attic" not in run("show", "Shelf lamp")[1]
    assert run("tag", "scan", "--teach", code) == (0, f"{told}shelf_lamp is in Attic now\n")
    assert "by the tag code at nfc" in run("show", "Shelf lamp")[1]
    run("place", "Shelf lamp", "Hall")
    assert run("tag", "scan", "--teach", code)[1].endswith("shelf_lamp is in Hall now\n")


@pytest.mark.parametrize("code", ["Shelf lamp", "Nobody\narea: Attic", "homebot:device/"])
def test_a_code_that_says_no_room_of_a_device_teaches_none(run: Run, code: str) -> None:
    assert run("tag", "scan", "--teach", code)[0] == 1
    assert "Attic" not in run("show", "Shelf lamp")[1]
