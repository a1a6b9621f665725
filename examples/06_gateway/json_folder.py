"""A gateway of your own: a lamp is a file ``NAME.json`` in a folder, such as ``{"name": "Hall", "on": true}``."""

from __future__ import annotations

from typing import ClassVar

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ValidationError

from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.graph import Node


class FolderSettings(BaseModel):
    """The table ``[gateways.NAME]``."""

    folder: str


class Lamp(BaseModel):
    """The content of a file."""

    name: str
    on: bool


class FolderGateway(Gateway):
    """Looks at the folder ten times a second; a device's key is the name of its file."""

    Settings: ClassVar[type[BaseModel]] = FolderSettings

    def __init__(self, node: Node, settings: FolderSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._folder = anyio.Path(settings.folder)
        self._lamps: dict[str, Lamp] = {}
        self._problem = f"there is no folder {settings.folder}"
        self._was_there: bool | None = None
        self._devices = PublishedDevices(self, self._perform)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        await self._look()
        task_status.started()
        while True:
            await anyio.sleep(0.1)
            await self._look()

    async def _look(self) -> None:
        is_there = await self._folder.is_dir()
        if is_there is not self._was_there:
            self._was_there = is_there
            self.publish_state("active" if is_there else "unavailable", "" if is_there else self._problem)
        if not is_there:
            return  # its devices stay: it may come back
        files = {path.stem: path async for path in self._folder.glob("*.json")}
        for key in self._lamps.keys() - files.keys():
            del self._lamps[key]
            self._devices.remove(key, "its file is gone")
        for key, path in files.items():
            try:
                lamp = Lamp.model_validate_json(await path.read_bytes())
            except (OSError, ValidationError):
                continue  # it is being written, or it is none
            if self._lamps.get(key) != lamp:
                self._lamps[key] = lamp
                part = simple_part("light", settable=("on_off",))
                self._devices.put(GatewayDevice(key, lamp.name, (part,)), "its file was written")
                await self._devices.report(key, {"on_off": lamp.on})

    async def _perform(self, command: Command) -> None:
        if not await self._folder.is_dir():
            raise LinkError(self._problem)
        lamp = self._lamps[command.key].model_copy(update={"on": command.value.plain()})
        await (self._folder / f"{command.key}.json").write_text(lamp.model_dump_json())
