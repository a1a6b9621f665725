"""``homebot places import`` with a map: of a file, and of the topic ``/map``."""

import math
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from tests.cli.conftest import NOW, Run
from tests.cli.test_places import index_node

from homebot.cli.robot_map import RobotMap  # not in two threads: Python 3.11 fails to compile in both at a time
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.errors import WireError
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Point, Pose, Quaternion
from homebot.messages.json import message_to_json
from homebot.messages.nav_msgs import MapMetaData, OccupancyGrid
from homebot.messages.std_msgs import Header
from homebot.places import read_places

ROOMS = {
    "Hall": {"polygon": [[0, 0], [4, 0], [4, 5], [0, 5]]},
    "Kitchen": {"polygon": [[4, 0], [8, 0], [8, 5], [4, 5]]},
}
YAML = "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
ROW = bytes([254] * 60 + [205] * 20)
"""The upper half of the map: the hall is free, and of the kitchen a half is unknown."""


def node(graph: Graph, message: OccupancyGrid | None) -> Node:
    index = DeviceIndex(
        forget_after=1000.0, owner=OwnerFacts("home425", read_places({"rooms": ROOMS}, "home425", "x", "x"), NOW)
    )
    made = index_node(index, graph)
    if message is not None:
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for topic in ("/map", "/rosie/map"):
            made.create_publisher(OccupancyGrid, topic, kept).publish(message)
    return made


@pytest.fixture
def run(run_with: Callable[..., Run], request: pytest.FixtureRequest) -> Run:
    return run_with(partial(node, message=getattr(request, "param", None)))


def test_rooms_are_imported_from_a_file_and_a_threshold_that_makes_unknown_cells_free_is_named(
    run: Run, tmp_path: Path
) -> None:
    (tmp_path / "map.pgm").write_bytes(b"P5 80 50 255\n" + ROW * 50)
    for threshold, warning, area in (("0.196", "", "30.0"), ("0.25", "makes the grey 205", "40.0")):
        (tmp_path / "map.yaml").write_text(YAML.replace("0.25", threshold))
        code, printed = run("places", "import", str(tmp_path / "map.yaml"), "--room", "Attic=5,1")
        assert code == 0
        assert warning in printed
        assert ("warning" in printed) is bool(warning)
        assert f"the map has 80 x 50 cells of 0.1 m\nAttic has {area} m²\nimported room Attic\n" in printed


def test_a_map_without_its_image_is_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text(YAML)
    code, printed = run("places", "import", str(tmp_path / "map.yaml"), "--room", "Attic=5,1")
    assert code == 1
    assert "map.pgm cannot be read: No such file" in printed


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("map.yaml",), "a map has walls and no rooms; give a point in each room: --room Hall=1,2"),
        (("house.toml", "--room", "Hall=1,2"), "--room is for the map of a robot"),
        (("map.yaml", "--room", "Hall"), "'Hall' is not a point in a room; write ROOM=X,Y"),
        (("map.yaml", "--room", "Hall=1"), "'1' is not a position"),
    ],
)
def test_a_wrong_import_of_a_map_is_refused(run: Run, arguments: tuple[str, ...], problem: str) -> None:
    code, printed = run("places", "import", *arguments)
    assert code
    assert problem in printed


FLOOR = OccupancyGrid(
    header=Header(stamp=Time(sec=0, nanosec=0), frame_id="map"),
    info=MapMetaData(
        map_load_time=Time(sec=0, nanosec=0),
        resolution=0.1,
        width=80,
        height=50,
        origin=Pose(position=Point(x=0.0, y=0.0, z=0.0), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)),
    ),
    data=((0,) * 60 + (-1,) * 20) * 50,
)


@pytest.mark.parametrize("run", [FLOOR], indirect=True, ids=["map"])
@pytest.mark.parametrize("topic", ["/map", "/rosie/map"])
def test_rooms_are_imported_from_the_map_of_a_robot(run: Run, topic: str) -> None:
    code, printed = run("places", "import", topic, "--room", "Attic=5,1")
    assert (code, printed) == (0, "the map has 80 x 50 cells of 0.1 m\nAttic has 30.0 m²\nimported room Attic\n")
    attic = tomllib.loads(run("places", "export")[1])["places"]["rooms"]["Attic"]
    assert sorted(attic["polygon"]) == [[0, 0], [0, 5], [6, 0], [6, 5]]


def test_a_file_named_map_is_no_topic(run: Run, tmp_path: Path) -> None:
    (tmp_path / "map").write_text("[places.rooms.Attic]\npolygon = [[0, 0], [6, 0], [6, 5]]\n")
    assert run("places", "import", str(tmp_path / "map"))[0] == 0


def test_a_map_of_a_robot_that_contradicts_itself_is_refused() -> None:
    def problem(**changed: object) -> str:
        info = FLOOR.info.model_copy(update=changed)
        with pytest.raises(WireError) as refused:
            RobotMap.of(message_to_json(FLOOR.model_copy(update={"info": info})))
        return refused.value.problem

    assert problem(height=51) == "the map has 4,000 cells, and states 80 x 51"
    assert problem(resolution=0.0) == "the map has cells of 0 m from 0,0"
    assert problem(resolution=math.nan) == "the map has cells of nan m from 0,0"
