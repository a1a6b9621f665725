"""A gateway to lamps that are files: ``NAME.lamp`` holds the state of a lamp, ``NAME.set`` the last command to it.

A lamp writes ``on`` or ``off`` into its file, and is removed with the file. The folder is read ten times a second.
While it is missing, such as a disk that is unplugged, the gateway is unavailable and keeps its lamps.
"""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.command import Command, SendCommand, SendCommandResponse
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.part import Capability, Part
from homebot.devices.report import Reading, Report
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.value import Value
from homebot.errors import HomebotError, UsageError
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.raw_delivery import RawDelivery
from homebot.graph import Node
from homebot.messages import Time

__all__ = ["FolderGateway", "FolderSettings"]

STALE_AFTER = 3600.0
MAX_LAMPS = 1000
READINGS = {b"on": True, b"off": False}


class FolderSettings(BaseModel):
    """The table ``[gateways.NAME]``.

    Attributes:
        folder: The folder of the lamps.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    folder: str


class FolderGateway(Gateway):
    """The gateway. The key of a lamp is its name; its addresses are the names of its two files."""

    Settings: ClassVar[type[BaseModel]] = FolderSettings

    def __init__(self, node: Node, settings: FolderSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._folder = anyio.Path(settings.folder)
        self._lamps: dict[str, bytes] = {}
        self._refused = 0
        self._is_available: bool | None = None
        self._raw = RawDelivery(node, self.names, inboxes=True)
        node.create_subscription(RawCommand, self.names.out, self._send_text)
        node.create_service(SendCommand, self.names.send_command, self._send)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe)
        node.create_service(GetHealth, self.names.health, self._get_health)

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
        is_available = await self._folder.is_dir()
        if is_available != self._is_available:
            self._is_available = is_available
            self.publish_state(*(("active",) if is_available else ("unavailable", f"{self._folder} does not exist")))
        if not is_available:
            return
        found = {path.stem: (await path.read_bytes()).strip() async for path in self._folder.glob("*.lamp")}
        for name in [name for name in self._lamps if name not in found]:
            del self._lamps[name]
            self._publish_sighting(name, "removed", "its file was deleted")
            self.reports.dispose(name)
        for name, payload in found.items():
            if name not in self._lamps and len(self._lamps) >= MAX_LAMPS:
                self._refused += 1
            elif self._lamps.get(name) != payload:
                await self._take(name, payload)

    async def _take(self, name: str, payload: bytes) -> None:
        is_known = name in self._lamps
        self._lamps[name] = payload
        self._publish_sighting(name, "updated" if is_known else "appeared", "its file was written")
        message = self._message(name, payload, retained=False)
        for listener in tuple(self._raw.of(message.address)):
            await self._raw.deliver(listener, message, wait_if_full=True)
        if payload in READINGS:
            self.reports.publish(
                Report(
                    gateway=self.node.name,
                    key=name,
                    readings=(Reading(part="", capability="on_off", value=Value.of(READINGS[payload])),),
                    address=message.address,
                    stream=name,
                    retained=False,
                    received_at=message.received_at,
                    heard_at=self.node.graph.clock.monotonic(),
                )
            )

    def _publish_sighting(self, name: str, kind: Literal["appeared", "updated", "removed"], why: str) -> None:
        part = Part(
            id="",
            service_type="light",
            advertised="lights",
            capabilities=(Capability(name="on_off", readable=True, settable=True),),
            reads=(f"{name}.lamp",),
            writes=(f"{name}.set",),
        )
        now = self.node.graph.clock.now()
        self.publish_sighting(
            Sighting(
                gateway=self.node.name,
                key=name,
                kind=kind,
                why=why,
                name=name,
                service_type="lights",
                address=f"{name}.lamp",
                command_address=f"{name}.set",
                parts=(part,),
                seen_at=Time.from_seconds(now),
                expires_at=Time.from_seconds(now + STALE_AFTER),
                confirmed=True,
                heard_at=self.node.graph.clock.monotonic(),
            )
        )

    async def _send_text(self, command: RawCommand) -> None:
        name = command.address.removesuffix(".set")
        if name in self._lamps and self._is_available:
            await (self._folder / f"{name}.set").write_text(command.payload)

    async def _send(self, command: Command) -> SendCommandResponse:
        on = command.value.plain()
        if not self._is_available:
            return SendCommandResponse(success=False, message="the folder is missing", problem="unreachable")
        if command.key not in self._lamps or command.capability != "on_off" or not isinstance(on, bool):
            message = f"{command.key} does not take {command.capability} {on}"
            return SendCommandResponse(success=False, message=message, problem="refused", unable=True)
        await (self._folder / f"{command.key}.set").write_text("on" if on else "off")
        return SendCommandResponse(success=True)

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        name = request.topic.removesuffix(".lamp")
        try:
            publisher = self._raw.add(request.topic, name, name, request.listener)
        except HomebotError as error:
            return SubscribeToTopicResponse(success=False, message=str(error), data_topic="")
        missed = (self._message(name, self._lamps[name], retained=True),) if name in self._lamps else ()
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=missed)

    def _get_health(self, _request: HealthRequest) -> HealthResponse:
        counts = (Count(name="lamps", count=len(self._lamps)), Count(name="lamps_refused", count=self._refused))
        return HealthResponse(counts=counts)

    def _message(self, name: str, payload: bytes, *, retained: bool) -> RawMessage:
        return RawMessage(
            gateway=self.node.name,
            key=name,
            address=f"{name}.lamp",
            payload=payload,
            retained=retained,
            received_at=Time.from_seconds(self.node.graph.clock.now()),
        )
