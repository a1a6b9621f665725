"""Persons of Home Assistant, by its WebSocket, as people of the house."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from tests.integrations.homeassistant.simulated.server import ListedEntity, SimulatedHomeAssistant
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices import Devices, Follow
from homebot.devices.device_lookup import DeviceLookup
from homebot.graph import Node
from homebot.runtime import Runtime
from homebot.words.house_queries import WordsQuery
from homebot.words.queries import parse_query

pytestmark = [pytest.mark.slow, pytest.mark.rooms("people")]


ANNA = 'Anna "Ann" O\'Neil'


class PlacedEntity(ListedEntity):
    """A person or a tracker, as Home Assistant 2026.11 has it without a device."""

    def __init__(self, entity_id: str, name: str, *trackers: str, shown: str = "home") -> None:
        super().__init__()
        self.entity_id, self.shown = entity_id, shown
        self.attributes = (
            {"friendly_name": name, "device_trackers": [*trackers]} if trackers else {"friendly_name": name}
        )

    def call(self, service: str, data: Mapping[str, object]) -> bool:
        del service, data
        return False

    def entry(self) -> Mapping[str, object]:
        domain, _, name = self.entity_id.partition(".")
        return {"id": f"entry of {self.entity_id}", "unique_id": name, "platform": domain, "original_name": None}

    def device_entry(self) -> Mapping[str, object]:
        return {}


@asynccontextmanager
async def house_of(
    home: SimulatedHomeAssistant, tmp_path: Path, *entities: PlacedEntity, **people: object
) -> AsyncIterator[Node]:
    token = tmp_path / "token"
    token.touch(mode=0o600)
    token.write_text(home.token)
    async with anyio.create_task_group() as tasks:
        await tasks.start(home.serve)
        for one in entities:
            home.reach(one)
        tables = {"gateways": {"homeassistant": {"url": home.url, "token_file": str(token)}}}
        config = parse_config(tables | ({"people": people} if people else {}), "test")
        async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "test") as node:
            with anyio.fail_after(PATIENCE):
                yield node
        tasks.cancel_scope.cancel()


def anna() -> PlacedEntity:
    return PlacedEntity("person.anna", ANNA, "device_tracker.phone")


@pytest.mark.parametrize("people", [{}, {"Mum": {"trackers": [ANNA]}}])
async def test_a_person_comes_goes_and_becomes_unknown(tmp_path: Path, people: dict[str, object]) -> None:
    home, person = SimulatedHomeAssistant(), anna()
    async with house_of(home, tmp_path, person, **people) as node:
        for place, query in (("home", "at_home=true"), ("Work", "at_home=false"), ("home", "at_home=true")):
            home.show(person, place, {})
            await anext(Follow(node, words=WordsQuery(f"household {query}")))
        home.show(person, "unavailable", {})
        for query in ("household not at_home=true", "household not at_home=false"):
            with anyio.fail_after(PATIENCE):
                while not await DeviceLookup(node).all_known(parse_query(query)):  # noqa: ASYNC110 - unknown is no move
                    await anyio.sleep(0.05)
        assert [one.name for one in await Devices(node).find("person")] == [next(iter(people), ANNA)]


@pytest.mark.parametrize(
    ("named", "found"),
    [({}, ["Anna", "Ben"]), ({"Mum": "Anna's phone"}, ["Ben", "Mum"]), ({"ben": "Anna's phone"}, ["ben"])],
)
async def test_one_is_a_person_by_a_tracker_and_only_once(
    tmp_path: Path, named: dict[str, str], found: list[str]
) -> None:
    """A person and the trackers are one, the table wins, and a kiosk's user is none."""
    entities = [
        PlacedEntity("person.anna", "Anna", "device_tracker.anna_s_phone"),
        PlacedEntity("device_tracker.anna_s_phone", "Anna's phone"),
        PlacedEntity("person.ben", "Ben", "device_tracker.ben_s_phone", shown="not_home"),
        PlacedEntity("device_tracker.ben_s_phone", "Ben's phone"),
        PlacedEntity("person.kiosk", "Kiosk", shown="unknown"),
        PlacedEntity("device_tracker.stranger", "Stranger"),
    ]
    people = {name: {"trackers": [tracker]} for name, tracker in named.items()}
    async with house_of(SimulatedHomeAssistant(), tmp_path, *entities, **people) as node:
        await anext(Follow(node, words=WordsQuery("household at_home=true")))
        assert sorted(one.name for one in await Devices(node).find("person")) == found


async def test_a_person_who_is_removed_is_no_person_any_more(tmp_path: Path) -> None:
    home, person = SimulatedHomeAssistant(), anna()
    async with house_of(home, tmp_path, person) as node:
        await anext(Follow(node, words=WordsQuery("household at_home=true")))
        people = Follow(node, words=WordsQuery("person or household"))
        assert [(await anext(people)).kind for _ in range(2)] == ["appeared", "appeared"]
        home.remove(person)
        gone = set[str]()
        while len(gone) < 2:
            if (change := await anext(people)).kind == "removed":
                gone.add(change.device.name)
        assert gone == {ANNA, "Household"}
