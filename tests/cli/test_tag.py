"""``homebot tag`` with a gateway whose reader a simulated tag is at, or is not."""

from collections.abc import Callable
from threading import Event

import pytest
from tests.cli.conftest import NOW, Homebot, HomebotWith, Run
from tests.cli.test_places import index_node, sighting
from tests.gateways.nfc.test_gateway import HOUSE
from tests.gateways.nfc.world import UID
from tests.patience import PATIENCE

from homebot.cli import main
from homebot.conventions.nfc.ndef_message import TagContent, TagError
from homebot.devices import FIND_DEVICES, QUERY_DEVICES, FindDevices, Found, QueryDevices
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse, QueryDevicesRequest, QueryDevicesResponse
from homebot.discovery import DeviceIndex
from homebot.gateways import GatewayContext
from homebot.gateways.nfc import NfcGateway, NfcGatewaySettings
from homebot.gateways.nfc.reader import ReaderDesk, TagReader, TagReaders
from homebot.graph import Graph, Node

Text = pytest.CaptureFixture[str]


class DeskTag:
    """An empty tag, or one that is not written because of an *error*."""

    uid, tag_type = UID, "NFC Forum Type 4"

    def __init__(self, error: TagError | None = None) -> None:
        self._message, self._error = b"", error

    def read(self) -> TagContent:
        return TagContent(self._message, 888, is_writable=True)

    def write(self, message: bytes) -> None:
        if self._error is not None:
            raise self._error
        self._message = message


class DeskReader(TagReader):
    """A reader with a tag on it."""

    def __init__(self, tag: DeskTag | None) -> None:
        self.is_found = Event()
        self._tag = tag

    def run(self, desk: ReaderDesk) -> None:
        desk.found("desk reader")
        self.is_found.set()
        if self._tag is not None:
            desk.arrived("desk reader", self._tag)
        while not desk.wait(0.02):
            if self._tag is not None:
                desk.stayed("desk reader", self._tag)


@pytest.fixture
def homebot_at(homebot_with: HomebotWith) -> Callable[[DeskTag | None], Homebot]:
    def start(tag: DeskTag | None) -> Homebot:
        reader = DeskReader(tag)

        def extra(graph: Graph) -> Node:
            node = Node(graph, "nfc", namespace="/gateway")
            settings = NfcGatewaySettings(teaches_place=False)  # there is no directory to teach
            gateway = NfcGateway(node, settings, context=GatewayContext.of(TagReaders((reader,))))
            node.create_task(gateway.serve)
            node.create_service(FindDevices, FIND_DEVICES, find)
            node.create_service(QueryDevices, QUERY_DEVICES, query)
            return node

        homebot = homebot_with(extra, None)
        assert reader.is_found.wait(PATIENCE)
        homebot.do(lambda: None)  # by then the loop has heard of it
        return homebot

    return start


def find(request: FindDevicesRequest) -> FindDevicesResponse:
    del request
    return FindDevicesResponse(devices=HOUSE, sequence=0)


def query(request: QueryDevicesRequest) -> QueryDevicesResponse:
    del request
    found = tuple(Found(device=one, score=1.0, reasons=()) for one in HOUSE)
    return QueryDevicesResponse(success=True, results=found, total=len(found))


def test_a_tag_is_written_and_read(homebot_at: Callable[[DeskTag | None], Homebot], capsys: Text) -> None:
    homebot = homebot_at(DeskTag())
    assert main(["--door", homebot.door, "tag", "write", "kitchen lamp", "--area", "Kitchen", "--wait", "10"]) == 0
    assert capsys.readouterr().out == (
        f"hold a tag to the reader; it will point to Kitchen lamp\ntag {UID} points to Kitchen lamp (lights/kitchen)\n"
    )
    assert main(["--door", homebot.door, "tag", "read"]) == 0
    assert capsys.readouterr().out == (
        f"tag {UID} (NFC Forum Type 4): it points to Kitchen lamp\n"
        "  device: lights/kitchen\n  area: Kitchen\n  reader: desk reader\n"
    )


@pytest.mark.parametrize(
    ("tag", "arguments", "code", "said"),
    [
        (None, ["read", "--reader", "attic"], 3, "there is no reader 'attic', only desk reader"),
        (None, ["read", "--wait", "0.1"], 4, "no tag was held to a reader within 0.1 s"),
        (DeskTag(TagError("too_small", "why")), ["write", "Plug"], 5, f"the tag {UID} was not written: why"),
        (DeskTag(TagError("protected", "it is write-protected")), ["write", "Plug"], 5, "it is write-protected"),
        (None, ["write", "Lamp"], 1, "2 devices are called Lamp; give the id of one: lights/cellar, lights/hall"),
        (
            None,
            ["read", "--gateway", "mqtt"],
            1,
            "no gateway mqtt that reads tags is running; a table [gateways.nfc] in",
        ),
    ],
)
def test_what_did_not_work_has_a_reason_and_a_code(
    homebot_at: Callable[[DeskTag | None], Homebot],
    capsys: Text,
    tag: DeskTag | None,
    arguments: list[str],
    code: int,
    said: str,
) -> None:
    homebot = homebot_at(tag)
    assert main(["--door", homebot.door, "tag", *arguments]) == code
    assert said in capsys.readouterr().err


def test_a_wait_without_end_is_a_wrong_command_line(capsys: Text) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["tag", "read", "--wait", "11m"])
    assert caught.value.code == 2
    assert "must be at most 600 seconds, got '11m'" in capsys.readouterr().err


def test_a_code_is_asked_about(homebot_at: Callable[[DeskTag | None], Homebot], capsys: Text) -> None:
    homebot = homebot_at(None)
    code = '{text: "homebot:device/lights/kitchen"}'
    assert main(["--door", homebot.door, "service", "call", "/gateway/nfc/scan", code]) == 0
    out = capsys.readouterr().out
    assert "device: lights/kitchen\n" in out
    assert "it points to Kitchen lamp" in out


def home(graph: Graph) -> Node:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(sighting(5, "Shelf lamp", ""), NOW)
    node = Node(graph, "nfc", namespace="/gateway")
    node.create_task(NfcGateway(node, context=GatewayContext.of(TagReaders(()))).serve)
    return index_node(index, graph)


@pytest.fixture
def run(run_with: Callable[..., Run]) -> Run:
    return run_with(home)


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
