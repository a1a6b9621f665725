"""The bridges of a house, with accessories that are not on any network; in virtual time."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.features.homekit_bridge.house import LAMP, LOCK, BridgedHouse, bridged_house

from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.names import APPLY_SCENE, LIST_SCENES
from homebot.devices.scene_messages import (
    ApplyScene,
    ApplySceneRequest,
    ListScenes,
    SceneInfo,
    ScenesRequest,
    ScenesResponse,
)
from homebot.features.homekit_bridge.bridge import MAX_COMMANDS
from homebot.features.homekit_bridge.hap import BUSY, NO_RESPONSE, OK, OnWrite
from homebot.features.homekit_bridge.messages import HomekitBridgeInfo
from homebot.features.homekit_bridge.services import HapValue, PartService
from homebot.gateways.announced.gateway_device import simple_part
from homebot.graph import Node

pytestmark = pytest.mark.virtual_time

BLIND = simple_part("window_covering", settable=("position",))


class FakeBridge:
    """A bridge without a network.

    Attributes:
        shown: The values of accessories by their numbers: of all services together.
        repeated: The accessories whose values were sent again.
    """

    made: list["FakeBridge"]

    def __init__(
        self, name: str, _address: str, _port: int, _clock: object, kept: Mapping[str, object], _on: object, **_: object
    ) -> None:
        self.name, self.kept, self.lost = name, kept, {"codes": 0}
        self.names: dict[int, str] = {}
        self.writers: dict[int, OnWrite] = {}
        self.shown: dict[int, dict[str, HapValue | None]] = {}
        self.there: dict[int, bool] = {}
        self.repeated: list[int] = []
        self.described = 0
        self.made.append(self)

    def put(self, aid: int, name: str, _model: str, _services: Iterable[PartService], on_write: OnWrite) -> None:
        self.names[aid], self.writers[aid] = name, on_write

    def remove(self, aid: int) -> None:
        del self.names[aid]

    def show(self, aid: int, name: str, values: Mapping[str, Mapping[str, HapValue | None]], *, is_there: bool) -> None:
        self.names[aid], self.there[aid] = name, is_there
        self.shown[aid] = {name: value for service in values.values() for name, value in service.items()}

    def repeat(self, aid: int, _service: str) -> None:
        self.repeated.append(aid)

    def describe(self) -> None:
        self.described += 1

    def state(self) -> dict[str, object]:
        return {"name": self.name}

    def info(self) -> HomekitBridgeInfo:
        return HomekitBridgeInfo(name=self.name, id="AA", address="", port=1)

    def unpair(self) -> int:
        return 0

    async def serve(self) -> None:
        await anyio.sleep_forever()

    def aid(self, name: str) -> int:
        return next(aid for aid, its in self.names.items() if its == name)

    def values(self, name: str) -> dict[str, HapValue | None]:
        return self.shown[self.aid(name)]

    async def write(self, name: str, service: str, **values: HapValue) -> int:
        return (await self.writers[self.aid(name)]({service: values}))[service]


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[FakeBridge]:
    bridges: list[FakeBridge] = []
    monkeypatch.setattr(FakeBridge, "made", bridges, raising=False)
    return bridges


make: Callable[..., Any] = FakeBridge


async def test_a_command_is_told_by_its_outcome_and_values_change_when_the_device_has_reported(
    made: list[FakeBridge],
) -> None:
    parts = {"hall_lamp": LAMP, "dead_lamp": LAMP, "stubborn_lamp": LAMP}
    async with bridged_house(None, parts, make, export=["light"]) as house:
        house.gateway.stubborn, house.gateway.silent = frozenset({"stubborn_lamp"}), frozenset({"dead_lamp"})
        (bridge,) = made
        assert await bridge.write("Hall lamp", "/Lightbulb", On=True, Brightness=30) == OK
        assert bridge.values("Hall lamp")["Brightness"] == 30.0
        assert await bridge.write("Stubborn lamp", "/Lightbulb", On=True) == NO_RESPONSE
        before = anyio.current_time()
        assert await bridge.write("Dead lamp", "/Lightbulb", On=True) == NO_RESPONSE
        assert anyio.current_time() - before < 10.0
        assert [bridge.values(name)["On"] for name in ("Hall lamp", "Stubborn lamp", "Dead lamp")] == [
            True,
            False,
            False,
        ]
        assert bridge.aid("Stubborn lamp") in bridge.repeated
        house.gateway.devices.report_reachable("hall_lamp", reachable=False)
        await anyio.sleep(2)
        assert [bridge.there[bridge.aid(name)] for name in ("Hall lamp", "Dead lamp")] == [False, True]


async def test_a_blind_is_on_its_way_when_the_controller_would_wait_no_longer(made: list[FakeBridge]) -> None:
    async with bridged_house(None, {"blind": BLIND}, make, export=["cover"]) as house:
        await house.report("blind", position=0.0)
        house.gateway.silent = frozenset({"blind"})
        await anyio.sleep(2)
        assert await made[0].write("Blind", "/WindowCovering", TargetPosition=100) == OK
        shown = made[0].values("Blind")
        assert (shown["CurrentPosition"], shown["TargetPosition"], shown["PositionState"]) == (0.0, 100.0, 1)
        await house.report("blind", position=100.0)
        await anyio.sleep(20)
        shown = made[0].values("Blind")
        assert (shown["CurrentPosition"], shown["TargetPosition"], shown["PositionState"]) == (100.0, 100.0, 2)


async def test_the_client_apple_commands_what_always_asks_only_if_it_is_named(made: list[FakeBridge]) -> None:
    parts = {"front_door": LOCK, "back_door": LOCK}
    async with bridged_house(None, parts, make, export=["lock", 'name="Front door"']) as house:
        assert [*made[0].names.values()] == ["Front door"]
        assert await made[0].write("Front door", "/LockMechanism", LockTargetState=0) == OK
        assert [command.value.plain() for command in house.gateway.commands] == ["unlocked"]


async def test_more_than_149_accessories_make_a_second_bridge_and_all_keep_their_places(
    made: list[FakeBridge], tmp_path: Path
) -> None:
    file = tmp_path / "homekit.pairings.json"
    parts = {f"lamp_{number:03}": LAMP for number in range(160)}
    async with bridged_house(file, parts, make, export=["light"], name="Haus"):
        assert [(bridge.name, len(bridge.names)) for bridge in made] == [("Haus", 149), ("Haus 2", 11)]
        before = [bridge.names for bridge in made]
    made.clear()
    async with bridged_house(file, dict(reversed(parts.items())), make, export=["light"], name="Haus") as house:
        assert sorted(map(sorted, (bridge.names.items() for bridge in made))) == sorted(
            map(sorted, (names.items() for names in before))
        )
        assert {bridge.name: bridge.kept for bridge in made} == {"Haus": {"name": "Haus"}, "Haus 2": {"name": "Haus 2"}}
        first = next(bridge for bridge in made if bridge.name == "Haus")
        house.gateway.devices.remove("lamp_000", "it is gone")
        await house.put("attic_lamp", LAMP, on_off=False)
        await anyio.sleep(2)
        assert "Attic lamp" in first.names.values()


async def test_a_restarted_bridge_waits_for_the_devices_that_it_had(made: list[FakeBridge], tmp_path: Path) -> None:
    file = tmp_path / "homekit.pairings.json"
    async with bridged_house(file, {"hall_lamp": LAMP}, make, export=["light"]):
        pass
    before = anyio.current_time()
    async with bridged_house(file, {}, make, export=["light"]):
        assert anyio.current_time() - before >= 60.0


async def test_a_house_that_is_busy_says_so(made: list[FakeBridge]) -> None:
    parts = {f"lamp_{number}": LAMP for number in range(MAX_COMMANDS + 1)}
    async with bridged_house(None, parts, make, export=["light"]) as house, anyio.create_task_group() as tasks:
        house.gateway.silent = frozenset(parts)
        lamps = [(bridge, name) for bridge in made for name in bridge.names.values()]
        for bridge, name in lamps[:-1]:
            tasks.start_soon(partial(bridge.write, name, "/Lightbulb", On=True))
        await anyio.sleep(0.1)
        assert await lamps[-1][0].write(lamps[-1][1], "/Lightbulb", On=True) == BUSY


async def test_a_scene_is_a_switch_that_springs_back(made: list[FakeBridge]) -> None:
    async with bridged_house(None, {}, make, scenes=["Evening"]) as house, Node(_graph(house), "scenes") as node:
        applied: list[ApplySceneRequest] = []

        def apply(request: ApplySceneRequest) -> CommandDevicesResponse:
            applied.append(request)
            return CommandDevicesResponse(success=True, message="")

        def scenes(_: ScenesRequest) -> ScenesResponse:
            found = tuple(SceneInfo(name=name, id=name) for name in ("Evening", "Morning"))
            return ScenesResponse(success=True, message="", scenes=found)

        node.create_service(ListScenes, LIST_SCENES, scenes)
        node.create_service(ApplyScene, APPLY_SCENE, apply)
        await anyio.sleep(70)
        assert [*made[0].names.values()] == ["Evening"]
        assert await made[0].write("Evening", "switch", On=True) == OK
        assert [(one.name, one.issuer, one.scope) for one in applied] == [
            ("Evening", "client:apple", ("act: ordinary",))
        ]
        assert (made[0].values("Evening"), made[0].repeated) == ({"On": False}, [made[0].aid("Evening")])


def _graph(house: BridgedHouse) -> Any:
    return house.gateway.node.graph
