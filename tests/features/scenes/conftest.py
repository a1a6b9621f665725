"""Fixtures: a home with control, as in ``tests/control``, and its scenes."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.control.conftest import Home, home, home_settings, open_home
from tests.one_task import in_one_task

from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.scene_messages import (
    ApplyScene,
    ApplySceneRequest,
    ChangeScene,
    ChangeSceneRequest,
    ChangeSceneResponse,
    ListScenes,
    SceneInfo,
    ScenesRequest,
    ScenesResponse,
)
from homebot.features.scenes import FEATURE
from homebot.features.scenes.scene_services import SceneServices
from homebot.graph import Node
from homebot.messages.json import message_from_json

__all__ = ["Kept", "Scenes", "home", "home_settings", "kept", "open_home", "scenes", "served"]


class Kept:
    """Keeps the scenes where a restart of the services finds them."""

    def __init__(self) -> None:
        self.record = self.on_disk = ""
        self.problem = ""

    def owner_record(self, feature: str) -> str:
        assert feature == "scenes"
        return self.record

    async def save_record(self, feature: str, record: str, *, at_once: bool) -> str:
        assert feature == "scenes"
        self.record = record
        self.on_disk = record if at_once else self.on_disk
        return self.problem if at_once else ""


class Scenes:
    """The services for scenes, asked as clients ask them."""

    def __init__(self, home: Home, kept: Kept) -> None:
        self.home = home
        self.kept = kept

    async def listed(self, name: str = "") -> ScenesResponse:
        await anyio.sleep(0.01)  # of virtual time, in which the directory takes everything in
        return await self.home.app.create_client(ListScenes, "/scenes/list").call(ScenesRequest(name=name))

    async def shown(self, name: str) -> SceneInfo:
        answer = await self.listed(name)
        assert answer.success, answer.message
        return answer.scenes[0]

    async def values(self, name: str) -> dict[str, str]:
        """Return the values in words, by the name of the part."""
        return {one.name: one.text for one in (await self.shown(name)).parts}

    async def change(self, **request: object) -> ChangeSceneResponse:
        await anyio.sleep(0.01)
        asked = message_from_json(ChangeSceneRequest, request)
        return await self.home.app.create_client(ChangeScene, "/scenes/change").call(asked)

    async def apply(self, name: str, **request: object) -> CommandDevicesResponse:
        await anyio.sleep(0.01)
        asked = message_from_json(ApplySceneRequest, {"name": name, "issuer": "client:local", **request})
        return await self.home.app.create_client(ApplyScene, "/scenes/apply").call(asked, timeout=900)


@pytest.fixture
def kept() -> Kept:
    return Kept()


@asynccontextmanager
async def served(home: Home, kept: Kept) -> AsyncIterator[Scenes]:
    """Serve the scenes until a restart."""
    async with Node(home.graph, "scenes") as node:
        services = SceneServices(node, lambda: kept)
        for service in FEATURE.services:
            services.serve(service.name)
        yield Scenes(home, kept)


@pytest.fixture
async def scenes(home: Home, kept: Kept) -> AsyncIterator[Scenes]:
    """The scenes of the home."""
    async with in_one_task(served(home, kept)) as found:
        yield found
