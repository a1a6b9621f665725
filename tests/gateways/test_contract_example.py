"""The gateway of the examples keeps the contract, and its lamp is found, switched and shown."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, ClassVar

import anyio
import pytest
from tests.patience import PATIENCE

from homebot import App, Light
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.plugins import load_plugin
from homebot.testing import TestHouse
from homebot.testing.gateway_contract import GatewayContract, Lamp

EXAMPLE = Path(__file__).parent.parent.parent / "examples" / "06_gateway"
CLASS = "json_folder:FolderGateway"


@pytest.fixture(autouse=True)
def in_its_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where it is run: a module that is not installed is found in the working directory."""
    monkeypatch.chdir(EXAMPLE)
    monkeypatch.syspath_prepend(EXAMPLE)


def write(file: Path, *, on: bool) -> None:
    """Write at once, as a program does that does not want to be read half-way."""
    whole = file.with_suffix(".new")
    whole.write_text(json.dumps({"name": "Hall", "on": on}))
    whole.replace(file)


class FileLamp(Lamp):
    """A lamp that is a file."""

    settings: ClassVar[Mapping[str, PlainValue]] = {"level": 40.0}

    def __init__(self, folder: Path) -> None:
        super().__init__("hall", address="hall.json")
        self._file = folder / "hall.json"
        self._own: str | None = None

    async def announce(self) -> None:
        await self.report(on=False)

    async def report(self, *, on: bool) -> None:
        write(self._file, on=on)
        self._own = self._file.read_text()

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"name": "Hall", "on": on}).encode()

    async def misbehave(self) -> None:
        """A file that is long and no lamp, and read ten times a second."""
        self._file.with_name("noise.json").write_bytes(b"?" * 1_500_000)

    async def withdraw(self) -> None:
        self._file.unlink()

    async def told(self) -> bool | None:
        order = self._order()
        return None if order is None else bool(order["on"])

    async def told_value(self, capability: str) -> PlainValue:
        order = self._order()
        return None if order is None else float(order[capability])

    def _order(self) -> dict[str, Any] | None:
        """The gateway writes what it tells the lamp into the file, in a spelling of its own."""
        content = self._file.read_text()
        return None if content in {"", self._own} else json.loads(content)

    async def lose_link(self) -> None:
        self._file.parent.rename(self._file.parent.with_name("away"))

    async def mend_link(self) -> None:
        self._file.parent.with_name("away").rename(self._file.parent)


class TestFolderGateway(GatewayContract):
    """One file."""

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self.folder = tmp_path / "lamps"
        self.folder.mkdir()

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        yield FileLamp(self.folder)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        del lamp
        kind = load_plugin("homebot.gateways", CLASS)
        made: Gateway = kind(node, kind.Settings(folder=str(self.folder), **settings))
        return made


@pytest.fixture
def homebot_config(tmp_path: Path) -> dict[str, object]:
    return {"gateways": {"folder": {"class": CLASS, "folder": str(tmp_path)}}}


async def becomes(file: Path, *, on: bool) -> None:
    with anyio.fail_after(PATIENCE):
        while json.loads(file.read_text() or "{}").get("on") is not on:  # noqa: ASYNC110 - a file tells nobody
            await anyio.sleep(0.02)


class Dusk(App):
    """Turns every light on once it is found."""

    async def run(self) -> None:
        async for change in self.devices.follow(Light, on=False):
            if change.kind == "appeared":
                (lamp,) = await self.devices.find(Light)
                await lamp.turn_on()


@pytest.mark.homebot.with_args(Dusk)
async def test_an_app_finds_the_lamp_and_turns_it_on(homebot: TestHouse, tmp_path: Path) -> None:
    """By ``find(Light)``."""
    assert homebot.crashed == ()
    write(tmp_path / "hall.json", on=False)
    await becomes(tmp_path / "hall.json", on=True)


def test_the_program_is_short() -> None:
    """As the guide promises."""
    assert len((EXAMPLE / "json_folder.py").read_text().splitlines()) <= 90
