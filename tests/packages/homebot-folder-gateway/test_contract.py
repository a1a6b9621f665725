"""The gateway keeps the contract of all gateways."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from homebot_folder.gateway import FolderGateway, FolderSettings

from homebot import Node
from homebot.gateways import Gateway
from homebot.testing.gateway_contract import GatewayContract, Lamp


class LampFile(Lamp):
    """A lamp that writes ``on`` or ``off`` into its file, and reads commands in another."""

    def __init__(self, folder: Path) -> None:
        super().__init__("Hall", address="Hall.lamp")
        self._folder = folder

    async def announce(self) -> None:
        await self.report(on=False)

    async def report(self, *, on: bool) -> None:
        (self._folder / "Hall.lamp").write_bytes(self.raw(on=on))

    def raw(self, *, on: bool) -> bytes:
        return b"on" if on else b"off"

    async def misbehave(self) -> None:
        """A file that is long and no lamp, and read ten times a second."""
        (self._folder / "Noise.lamp").write_bytes(b"?" * 1_500_000)

    async def withdraw(self) -> None:
        (self._folder / "Hall.lamp").unlink()

    async def told(self) -> bool | None:
        file = self._folder / "Hall.set"
        return file.read_text() == "on" if file.exists() and file.read_text() else None

    async def lose_link(self) -> None:
        self._folder.rename(self._folder.with_name("unplugged"))

    async def mend_link(self) -> None:
        self._folder.with_name("unplugged").rename(self._folder)


class TestFolderOfThePackage(GatewayContract):
    """One file."""

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self.folder = tmp_path / "lamps"
        self.folder.mkdir()

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        yield LampFile(self.folder)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        del lamp
        table = FolderSettings.model_validate({"folder": str(self.folder), **settings})
        return FolderGateway(node, table)
