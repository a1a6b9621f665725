"""Persons of Home Assistant, by its WebSocket, as people of the house."""

from collections.abc import Mapping
from pathlib import Path

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices import Follow
from homebot.graph import Node
from homebot.integrations.homeassistant.simulated.server import ListedEntity, SimulatedHomeAssistant
from homebot.runtime import Runtime

pytestmark = pytest.mark.slow


class PersonEntity(ListedEntity):
    """A person, as Home Assistant 2026.11 has it without a device."""

    entity_id = "person.anna"

    def __init__(self) -> None:
        super().__init__()
        self.shown = "home"
        self.attributes = {"id": "anna", "user_id": None, "device_trackers": [], "friendly_name": "Anna"}

    def call(self, service: str, data: Mapping[str, object]) -> bool:
        del service, data
        return False

    def entry(self) -> Mapping[str, object]:
        return {"id": "e1", "unique_id": "anna", "platform": "person", "original_name": "Anna"}

    def device_entry(self) -> Mapping[str, object]:
        return {}


async def test_a_person_comes_goes_and_becomes_unknown(tmp_path: Path) -> None:
    home, anna = SimulatedHomeAssistant(), PersonEntity()
    token = tmp_path / "token"
    token.touch(mode=0o600)
    token.write_text(home.token)
    async with anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        home.reach(anna)
        tables = {"homeassistant": {"url": home.url, "token_file": str(token)}}
        config = parse_config({"gateways": tables, "people": {"Anna": {"trackers": ["Anna"]}}}, "test")
        async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "test") as node:
            with anyio.fail_after(PATIENCE):
                for place, query in (("home", "at_home=true"), ("Work", "at_home=false"), ("home", "at_home=true")):
                    home.show(anna, place, {})
                    await anext(Follow(node, query=f"household {query}"))
                home.show(anna, "unavailable", {})
                await anext(Follow(node, query="household not at_home=true"))
                await anext(Follow(node, query="household not at_home=false"))
        tasks.cancel_scope.cancel()
