"""A gateway to devices that exist in the test alone: no sockets, so it runs in virtual time."""

from __future__ import annotations

from collections import defaultdict, deque
from typing import ClassVar, Literal

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict

from homebot.devices import RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import HomebotError
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.announced.part_texts import missed
from homebot.gateways.announced.reporter import stamps
from homebot.gateways.raw_delivery import RawDelivery, begin_of
from homebot.graph import Node
from homebot.messages import Time

__all__ = ["FakeGateway", "FakeGatewaySettings"]

KEPT = 10


class FakeGatewaySettings(BaseModel):
    """The settings of the fake.

    Attributes:
        delivery: As for MQTT.
        stale_after: Seconds of silence after which a device is stale.
        refused: Addresses that nobody may listen to.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    delivery: Literal["inbox", "mirror"] = "inbox"
    stale_after: float = 3600.0
    refused: tuple[str, ...] = ()


class FakeGateway(Gateway):
    """Devices are called by their key, ``SERVICE_TYPE/DEVICE_ID``; they speak on ``KEY/out`` and listen on ``KEY/in``.

    Attributes:
        told: The commands that came, oldest first.
    """

    Settings: ClassVar[type[BaseModel]] = FakeGatewaySettings

    def __init__(
        self, node: Node, settings: FakeGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        self._settings = settings or FakeGatewaySettings()
        super().__init__(node, self._settings, context)
        self.told: list[tuple[str, str]] = []
        self._listeners = RawDelivery(node, self.names, inboxes=self._settings.delivery == "inbox")
        self._kept: defaultdict[str, deque[tuple[float, RawMessage]]] = defaultdict(lambda: deque(maxlen=KEPT))
        node.create_subscription(RawCommand, self.names.out, self._send, 1000)
        node.create_service(SubscribeToTopic, self.names.subscribe, self._subscribe)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be there until cancelled."""
        task_status.started()
        await anyio.sleep_forever()

    async def says(self, key: str, payload: str | bytes, *, name: str = "", takes_commands: bool = True) -> None:
        """Let the device *key* say *payload*: it is sighted, and whoever listens hears it."""
        self.sees(key, name=name, takes_commands=takes_commands)
        message = RawMessage(
            gateway=self.node.name,
            key=key,
            address=f"{key}/out",
            payload=payload.encode() if isinstance(payload, str) else payload,
            retained=False,
            received_at=self._now(),
        )
        self._kept[message.address].append((self.node.graph.clock.monotonic(), message))
        for listener in tuple(self._listeners.of(message.address)):
            await self._listeners.deliver(listener, message, wait_if_full=True)

    def sees(
        self,
        key: str,
        *,
        kind: Literal["appeared", "updated", "removed"] = "updated",
        service_type: str = "",
        name: str = "",
        takes_commands: bool = True,
        confirmed: bool = True,
    ) -> None:
        """Sight the device *key*; what it offers is the first part of its key unless said otherwise."""
        now, until = stamps(self.node.graph.clock.now(), self._settings.stale_after)
        self.publish_sighting(
            Sighting(
                gateway=self.node.name,
                key=key,
                kind=kind,
                why="the test says so",
                name=name or key.rpartition("/")[2],
                service_type=service_type or key.partition("/")[0],
                address=f"{key}/out",
                command_address=f"{key}/in" if takes_commands else "",
                native=True,
                seen_at=now,
                expires_at=until,
                confirmed=confirmed,
                heard_at=self.node.graph.clock.monotonic(),
            )
        )

    def removes(self, key: str) -> None:
        """Take the device *key* out of the house."""
        self._kept.pop(f"{key}/out", None)
        self.sees(key, kind="removed")

    def _send(self, command: RawCommand) -> None:
        self.told.append((command.address, command.payload))

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        if request.topic in self._settings.refused:
            return SubscribeToTopicResponse(success=False, message="the test refuses it", data_topic="")
        key = request.topic.removesuffix("/out")
        is_new = not self._listeners.has(request.topic, request.listener)
        try:
            publisher = self._listeners.add(request.topic, key, key.rpartition("/")[2], request.listener)
        except HomebotError as exc:
            return SubscribeToTopicResponse(success=False, message=str(exc), data_topic="")
        since = begin_of(request.since, self.node.graph.clock)
        kept = missed(self._kept[request.topic], since) if is_new else ()
        return SubscribeToTopicResponse(success=True, message="", data_topic=publisher.topic_name, missed=kept)

    def _now(self) -> Time:
        return Time.from_seconds(self.node.graph.clock.now())
