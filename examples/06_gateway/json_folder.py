"""A gateway of your own: a lamp is a file ``NAME.json`` in a folder, such as ``{"name": "Hall", "on": true}``."""

from __future__ import annotations

import contextlib

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ValidationError

from homebot import Node
from homebot.devices import Command, implied_settings
from homebot.errors import LinkError
from homebot.gateways import Gateway, GatewayContext, GatewayDevice, GatewaySettings, PublishedDevices, simple_part


class FolderSettings(GatewaySettings):  # the table [gateways.NAME]
    folder: str


class Lamp(BaseModel):
    """The content of a file."""

    name: str
    on: bool
    level: float = 100.0  # kept while it is off


FIELDS = {"on_off": "on", "level": "level"}  # by capability


class FolderGateway(Gateway):
    """Looks at the folder ten times a second; a device's key is the name of its file."""

    Settings = FolderSettings

    def __init__(self, node: Node, settings: FolderSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._folder = anyio.Path(settings.folder)
        self._problem = f"there is no folder {self._folder}"
        self._lamps: dict[str, Lamp] = {}
        self._devices = PublishedDevices(self, self._perform, settings)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        await self._look()
        task_status.started()
        while True:
            await anyio.sleep(0.1)
            await self._look()

    async def _look(self) -> None:
        try:
            files = {path.stem: path async for path in self._folder.iterdir() if path.suffix == ".json"}
        except FileNotFoundError:
            self.publish_state("unavailable", self._problem)
            return  # its devices stay: it may come back
        self.publish_state("active")
        for key in self._lamps.keys() - files.keys():
            del self._lamps[key]
            self._devices.remove(key, "its file is gone")
        for key, path in files.items():
            with contextlib.suppress(FileNotFoundError):  # it is gone again
                if self._devices.admits(key):
                    await self._read(key, await path.read_bytes())

    async def _read(self, key: str, content: bytes) -> None:
        try:
            lamp = Lamp.model_validate_json(content)
        except ValidationError:
            self._devices.reject(key, content, "it holds no lamp")
            return
        if self._lamps.get(key) != lamp:
            self._lamps[key] = lamp
            part = simple_part("light", settable=tuple(FIELDS))
            self._devices.put(GatewayDevice(key, lamp.name, (part,), raw_address=f"{key}.json"), "its file was written")
            await self._devices.deliver_raw(key, content)
            await self._devices.report(key, {"on_off": lamp.on, "level": lamp.level})

    async def _perform(self, command: Command) -> None:
        if not await self._folder.is_dir():
            raise LinkError(self._problem)
        settings = implied_settings(command.capability, command.value.plain(), FIELDS)  # a level turns it on, too
        lamp = self._lamps[command.key].model_copy(update={FIELDS[name]: value for name, value in settings})
        await (self._folder / f"{command.key}.json").write_text(lamp.model_dump_json())
