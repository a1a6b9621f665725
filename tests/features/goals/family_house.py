"""The family house of ``examples/`` and its robot, in virtual time, with sliding doors and a lock."""

from __future__ import annotations

import tomllib
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, Final

import anyio

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices.journal_messages import ExplainDevice, ExplainDeviceRequest
from homebot.devices.names import (
    ANSWER_QUESTION,
    CHANGE_SCENE,
    EXPLAIN_DEVICE,
    IMPORT_PLACES,
    OPEN_QUESTIONS,
)
from homebot.devices.places_messages import ImportPlaces, ImportPlacesRequest
from homebot.devices.question_messages import AnswerQuestion, AnswerQuestionRequest, OpenQuestions
from homebot.devices.scene_messages import ChangeScene, ChangeSceneRequest
from homebot.devices.wording.journal_words import finding_text
from homebot.features.goals import ACHIEVE
from homebot.features.goals.messages import Achieve, AchieveFeedback, AchieveGoal, AchieveResult
from homebot.graph import Node, qos_profile_latched
from homebot.graph.actions import ActionClient, ClientGoal
from homebot.house import World
from homebot.house.description import parse_world
from homebot.messages.json import message_from_json
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime

FAMILY: Final = tomllib.loads((Path(__file__).parents[3] / "examples/houses/family.toml").read_text("utf-8"))
SLIDING: Final = {"kind": "cover", "is_open": False, "travel_time": 5.0}
MORE: Final[dict[str, dict[str, Any]]] = {
    "kitchen_slide": {**SLIDING, "room": "kitchen"},
    "bedroom_slide": {**SLIDING, "room": "bedroom"},
    "bedroom_lock": {"kind": "lock", "room": "bedroom"},
    "nursery_slide": {**SLIDING, "room": "nursery", "faults": {"deaf": {}}},
    "nursery_window": {"kind": "window", "room": "nursery"},
    "stairs_floor_lamp": {"kind": "lamp", "room": "stairs", "faults": {"deaf": {}}},
}
"""The kitchen door has a motor, and the bedroom's a lock too; a lamp and the motor of the nursery's do not obey."""

DASH: Final = "\N{EN DASH}"
DOORS: Final = f"""
[[places.doors]]
name = "kitchen{DASH}living"
rooms = ["kitchen", "living"]
contact = "kitchen_slide"
[[places.doors]]
name = "bedroom{DASH}stairs"
rooms = ["bedroom", "stairs"]
contact = "bedroom_slide"
lock = "bedroom_lock"
[[places.doors]]
name = "nursery{DASH}stairs"
rooms = ["nursery", "stairs"]
contact = "nursery_slide"
[[places.doors]]
name = "front door"
rooms = ["hall", "outside"]
contact = "front_door"
lock = "front_lock"
"""
NIGHT: Final = 1_767_225_600.0
"""2026-01-01 00:00 UTC: everybody sleeps."""


class FamilyHouse:
    """The house, and a client of its goals."""

    def __init__(self, node: Node, world: World) -> None:
        self.node, self.world = node, world
        self.questions: list[OpenQuestions] = []
        self.feedback: list[AchieveFeedback] = []
        node.create_subscription(OpenQuestions, OPEN_QUESTIONS, self.questions.append, qos_profile_latched)

    async def furnish(self) -> None:
        """State the doors, and save a scene."""
        await anyio.sleep(5.0)  # all devices are found, and the robot has said where it is
        places = self.node.create_client(ImportPlaces, IMPORT_PLACES)
        answer = await places.call(ImportPlacesRequest(text=DOORS))
        assert answer.success, answer.message
        values = [{"key": "living_lamp", "value": "off"}, {"key": "living_floor_lamp", "value": "on, 20 %"}]
        film = {"name": "Film", "change": "save", "values": values}
        scenes = self.node.create_client(ChangeScene, CHANGE_SCENE)
        saved = await scenes.call(message_from_json(ChangeSceneRequest, film))
        assert saved.success, saved.message

    async def achieve(self, goal: str, **more: Any) -> AchieveResult:
        return (await (await self.begin(goal, **more)).result())[1]

    async def begin(self, goal: str, **more: Any) -> ClientGoal[AchieveResult, AchieveFeedback]:
        client = ActionClient(self.node, Achieve, ACHIEVE.name)
        asked = AchieveGoal(goal=goal, **{"issuer": "client:anna", "scope": ("read", "act: all"), **more})
        return await client.send_goal(asked, self.feedback.append)

    async def answer(self, *, yes: bool) -> None:
        """Answer the open question, as the owner."""
        await anyio.sleep(2.0)
        asked = AnswerQuestionRequest(
            question=self.questions[-1].questions[0].question, yes=yes, issuer="client:owner", scope=("act: all",)
        )
        answered = await self.node.create_client(AnswerQuestion, ANSWER_QUESTION).call(asked)
        assert answered.success, answered.message

    async def why(self, device: str) -> str:
        asked = ExplainDeviceRequest(device=device)
        found = await self.node.create_client(ExplainDevice, EXPLAIN_DEVICE).call(asked)
        assert found.success, found.message
        return finding_text(found, {}, self.node.graph.clock.now())

    def told(self) -> list[tuple[str, str]]:
        """Return the commands that devices got, oldest first."""
        return [
            (one.who, one.what) for one in self.world.event_log.since(0) if one.verb == "told" and one.who != "robot"
        ]


@asynccontextmanager
async def family_house(
    config: Mapping[str, object] | None = None, index_file: Path | None = None
) -> AsyncIterator[FamilyHouse]:
    """Run the house without its errands."""
    tables = {**FAMILY, "devices": {**FAMILY["devices"], **MORE}, "errands": []}
    world = parse_world(tables, "family.toml")
    tables = {"home": {"name": "home425"}, "gateways": {"mqtt": {"root": "home425"}}, **(config or {})}
    async with MemoryBroker() as broker:
        runtime = Runtime(
            parse_config(tables, "test"),
            house=world,
            robot="robot",
            clock=LoopClock(NIGHT),
            with_door=False,
            index_file=index_file,
            services=(HostedBroker.in_memory(broker),),
        )
        async with runtime, Node(runtime.graph, "client") as node:
            house = FamilyHouse(node, world)
            await house.furnish()
            yield house
