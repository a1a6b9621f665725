"""The gateway to a folder of lamps."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot import Capability, Node, Part
from homebot.devices import Command, RawCommand
from homebot.errors import LinkError, RefusedError, UsageError
from homebot.gateways import Gateway, GatewayContext, GatewayDevice, GatewaySettings, PublishedDevices

MAX_LAMPS = 1000
MAX_BYTES = 1000
STATES = {b"on": True, b"off": False}


class FolderSettings(GatewaySettings):
    """The table ``[gateways.NAME]``.

    Attributes:
        folder: The folder of the lamps.
    """

    folder: str


class FolderGateway(Gateway):
    """The gateway. The key of a lamp is its name; its addresses are the names of its two files."""

    Settings: ClassVar[type[BaseModel]] = FolderSettings

    def __init__(self, node: Node, settings: FolderSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._folder = anyio.Path(settings.folder)
        self._lamps: dict[str, bytes] = {}
        self._devices = PublishedDevices(self, self._perform, settings, send_raw=self._send_raw, max_devices=MAX_LAMPS)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Refuse a folder that does not exist.

        Raises:
            UsageError: It does not.
        """
        assert isinstance(settings, FolderSettings)
        if not Path(settings.folder).is_dir():
            raise UsageError(f"folder {settings.folder!r} does not exist")

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Read the folder until cancelled."""
        await self._read_folder()
        task_status.started()
        while True:
            await anyio.sleep(0.1)
            await self._read_folder()

    async def _read_folder(self) -> None:
        try:  # one look: the folder may go missing between two
            found = {path.stem: path async for path in self._folder.iterdir() if path.suffix == ".lamp"}
        except FileNotFoundError:
            self.publish_state("unavailable", f"{self._folder} does not exist")
            return
        self.publish_state("active")
        for name in self._lamps.keys() - found.keys():
            del self._lamps[name]
            self._devices.remove(name, "its file was deleted")
        for name, path in list(found.items())[:MAX_LAMPS]:
            if self._devices.admits(name):
                with suppress(FileNotFoundError):  # it was deleted again
                    await self._take(name, (await path.read_bytes()).strip())

    async def _take(self, name: str, payload: bytes) -> None:
        if len(payload) > MAX_BYTES:
            self._devices.reject(name, payload, f"it is longer than {MAX_BYTES:,} bytes")
        elif self._lamps.get(name) != payload:
            self._lamps[name] = payload
            await self._publish(name, payload)

    async def _publish(self, name: str, payload: bytes) -> None:
        on_off = Capability(name="on_off", settable=True)
        part = Part(id="", service_type="light", advertised="lights", capabilities=(on_off,))
        lamp = GatewayDevice(
            name, name, (part,), service_type="lights", address=f"{name}.lamp", command_address=f"{name}.set"
        )
        self._devices.put(lamp, "its file was written")
        await self._devices.deliver_raw(name, payload)
        if payload in STATES:
            await self._devices.report(name, {"on_off": STATES[payload]})

    async def _perform(self, command: Command) -> None:
        await self._write(command.key, "on" if command.value.plain() else "off")

    async def _send_raw(self, command: RawCommand) -> None:
        name = command.address.removesuffix(".set")
        if name not in self._lamps:
            raise RefusedError(f"a command to {command.address}", "there is no such lamp")
        await self._write(name, command.payload)

    async def _write(self, name: str, payload: str) -> None:
        if not await self._folder.is_dir():
            raise LinkError(f"{self._folder} does not exist")
        await (self._folder / f"{name}.set").write_text(payload)
