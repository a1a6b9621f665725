"""The driver for WLED controllers.

The controller sends its whole state over a WebSocket whenever it changes. Without a WebSocket, or without room for
another client, it is polled every ten seconds. Commands are sent over HTTP, because the WebSocket does not acknowledge
them.

Source: WLED, https://kno.wled.ge/interfaces/websocket and /json-api.
"""

from collections.abc import Awaitable, Callable, Collection, Mapping
from typing import TYPE_CHECKING, ClassVar, Final

import anyio

from homebot.conventions.payload import as_fields, parse_object
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService, first_answer
from homebot.gateways.http_address import http_origin
from homebot.integrations.wled.formats.strip import Fields, WledStrip, effect_names, preset_names
from homebot.support.isolation import ungrouped

if TYPE_CHECKING:
    from homebot.gateways.http_client import HttpClient

MAX_BYTES: Final = 128 * 1024
"""Longest answer; with 32 segments it has about 12 kB."""

POLL: Final = 10.0
"""Seconds between polls if nothing is pushed."""

ANSWER_WITHIN: Final = 5.0
"""Seconds for an answer; three consecutive misses end the connection."""

ASK_AGAIN: Final = 300.0
"""The same as :data:`POLL` if state is pushed, as an unused lamp is silent for days."""

_TRIES = 3
_PAUSE = 0.3
"""A controller that is busy with another request answers 503, and is soon free again."""


class WledDriver(Driver):
    """One light strip, or several on one controller."""

    service_types: ClassVar[frozenset[str]] = frozenset({"_wled._tcp.local."})
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        super().__init__(service, settings, host)
        self._client: HttpClient
        self._origin = ""
        self._strip: WledStrip | None = None
        self._effects: tuple[str, ...] = ()
        self._presets: Mapping[int, str] = {}
        self._presets_of: object = None

    async def run(self) -> None:
        """Connect, and report the controller's states, until cancelled."""

        async def ask(address: str) -> Fields:
            self._origin = http_origin(address, self.service.port)
            return as_fields(await self._ask("/json/si"))

        async with self.http_client(MAX_BYTES, ANSWER_WITHIN) as self._client:
            try:
                document = await first_answer(self.service.name, self.service.addresses, ask)
                self._effects = effect_names(await self._ask("/json/eff"))
                await self._update(document)
                try:
                    async with self._client.websocket(f"{self._origin}/ws") as socket:
                        with ungrouped():
                            async with anyio.create_task_group() as tasks:
                                tasks.start_soon(self._poll, ASK_AGAIN)
                                await socket.receive_all(self._receive, self.host.reject)
                except RefusedError:
                    await self._poll(POLL)
            finally:
                self._strip = None

    async def perform(self, command: Command) -> Collection[str]:
        """Carry out a command; return when the controller has accepted it."""
        if self._strip is None:
            raise LinkError(f"{self.service.name} is not connected")
        values = {setting.capability: setting.value.plain() for setting in command.singly()}
        state = self._strip.write(command.part, values, command.transition)
        url, document = f"{self._origin}/json/state", {**state, "v": True}
        # a state is absolute, so it can be sent again
        answer = as_fields(await _patiently(lambda: self._client.send_json("POST", url, document)))
        if "error" in answer:
            raise RefusedError(
                f"a command to {self.service.name}", f"the device answered error {answer['error']!s:.20}"
            )
        if "on" in answer:
            await self._publish(self._strip.with_state(answer))
        return values

    async def _receive(self, payload: bytes) -> None:
        await self.host.deliver_raw(payload)
        document = parse_object(payload, MAX_BYTES)
        if "state" in document or "info" in document:  # else it answers with success or error
            await self._update(document)

    async def _poll(self, interval: float) -> None:
        while True:
            await anyio.sleep(interval)
            await self._update(as_fields(await self._ask("/json/si")))

    async def _ask(self, path: str) -> object:
        return await _patiently(lambda: self._client.get_json(f"{self._origin}{path}"))

    async def _update(self, document: Fields) -> None:
        files = as_fields(as_fields(document.get("info")).get("fs"))
        if "pmt" in files and files["pmt"] != self._presets_of:
            try:
                self._presets = preset_names(await self._ask("/presets.json"))
            except RefusedError:
                self._presets = {}
            except WireError as error:
                self.host.reject(b"", f"its presets cannot be read: {error}")
                self._presets = {}
            self._presets_of = files["pmt"]
        await self._publish(WledStrip(document, self._effects, self._presets))

    async def _publish(self, strip: WledStrip) -> None:
        """Publish description and state of the controller, or only that it is still there if nothing has changed."""
        self._strip = strip
        device = GatewayDevice(
            key=self.service.key,
            name=strip.name or self.service.name,
            parts=strip.parts(),
            metadata=strip.metadata,
            identifiers=strip.identifiers,
        )
        self.host.describe(device)
        for part, readings in strip.readings():
            await self.host.report(readings, part)


async def _patiently(request: Callable[[], Awaitable[object]]) -> object:
    for _ in range(_TRIES - 1):
        try:
            return await request()
        except LinkError:
            await anyio.sleep(_PAUSE)
    return await request()
