"""A gateway to lamps that are files: ``NAME.lamp`` holds what the lamp reports, ``NAME.set`` what it was last told.

A lamp writes ``on`` or ``off`` into its file, and is gone when the file is. The folder is looked at ten times a second.
"""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.command import Command, SendCommand, SendCommandResponse
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
WORDS = {b"on": True, b"off": False}


class FolderSettings(BaseModel):
    """The table ``[gateways.NAME]``.

    Attributes:
        folder: Where the lamps are.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    folder: str


class FolderGateway(Gateway):
    """The gateway. A lamp's key and address are its name, and its file's name."""

    Settings: ClassVar[type[BaseModel]] = FolderSettings

    def __init__(self, node: Node, settings: FolderSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._folder = anyio.Path(settings.folder)
        self._lamps: dict[str, bytes] = {}
        self._listeners = RawDelivery(node, self.names, inboxes=True)
        node.create_subscription(RawCommand, self.names.out, self._send)
        node.create_service(SendCommand, self.names.send_command, self._command)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Refuse a folder that is not there."""
        assert isinstance(settings, FolderSettings)
        if not Path(settings.folder).is_dir():
            raise UsageError(f"folder {settings.folder!r} does not exist")

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Look at the folder until cancelled."""
        await self._look()
        self.publish_state("active")
        task_status.started()
        while True:
            await anyio.sleep(0.1)
            await self._look()

    async def _look(self) -> None:
        found = {path.stem: (await path.read_bytes()).strip() async for path in self._folder.glob("*.lamp")}
        for name in [name for name in self._lamps if name not in found]:
            del self._lamps[name]
            self._sight(name, "its file is gone", "removed")
        for name, payload in list(found.items())[:MAX_LAMPS]:
            if self._lamps.get(name) != payload:
                self._lamps[name] = payload
                await self._tell(name, payload)

    async def _tell(self, name: str, payload: bytes) -> None:
        self._sight(name, "its file was written", "updated")
        message = RawMessage(
            gateway=self.node.name,
            key=name,
            address=f"{name}.lamp",
            payload=payload,
            retained=False,
            received_at=self._now,
        )
        for listener in tuple(self._listeners.of(message.address)):
            await self._listeners.deliver(listener, message, wait_if_full=True)
        if payload in WORDS:
            reading = Reading(part="", capability="on_off", value=Value.of(WORDS[payload]))
            self.reports.publish(
                Report(
                    gateway=self.node.name,
                    key=name,
                    readings=(reading,),
                    stream=name,
                    retained=False,
                    received_at=self._now,
                )
            )

    def _sight(self, name: str, why: str, kind: Literal["updated", "removed"]) -> None:
        on_off = Capability(name="on_off", readable=True, settable=True)
        part = Part(
            id="",
            service_type="light",
            advertised="lights",
            capabilities=(on_off,),
            reads=(f"{name}.lamp",),
            writes=(f"{name}.set",),
        )
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
                seen_at=self._now,
                expires_at=Time.from_seconds(self.node.graph.clock.now() + STALE_AFTER),
                confirmed=True,
                heard_at=self.node.graph.clock.monotonic(),
            )
        )

    async def _send(self, command: RawCommand) -> None:
        name = command.address.removesuffix(".set")
        if name in self._lamps:
            await (self._folder / f"{name}.set").write_text(command.payload)

    async def _command(self, command: Command) -> SendCommandResponse:
        if command.key not in self._lamps:
            return SendCommandResponse(success=False, message=f"there is no lamp {command.key}", problem="refused")
        await (self._folder / f"{command.key}.set").write_text("on" if command.value.plain() else "off")
        return SendCommandResponse(success=True)

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        name = request.topic.removesuffix(".lamp")
        try:
            publisher = self._listeners.add(request.topic, name, name, request.listener)
        except HomebotError as error:
            return SubscribeToTopicResponse(success=False, message=str(error), data_topic="")
        message = self._lamps.get(name)
        missed = (
            ()
            if message is None
            else (
                RawMessage(
                    gateway=self.node.name,
                    key=name,
                    address=request.topic,
                    payload=message,
                    retained=True,
                    received_at=self._now,
                ),
            )
        )
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=missed)

    @property
    def _now(self) -> Time:
        return Time.from_seconds(self.node.graph.clock.now())
