"""The driver for Shelly's devices of the second generation and later, and its table ``[gateways.mdns.drivers.shelly]``.

Source: Shelly Gen2+ API, Overview, Common Device Traits (mDNS); General: RPC Protocol (frames, common errors), RPC
Channels (WebSocket), Notifications.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Final, TypeAlias

import anyio
from pydantic import Field, SecretStr

from homebot.conventions.payload import Readings, as_fields, clean_text, compact_json, parse_object, text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.identity import identifiers, in_pairs
from homebot.errors import HomebotError, LinkError, PeerError, RefusedError, UsageError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService, first_answer
from homebot.gateways.http_address import http_origin
from homebot.gateways.password_settings import PasswordSettings
from homebot.gateways.pending_calls import PendingCalls
from homebot.integrations.shelly.bluetooth_proxy import BluetoothRelay
from homebot.integrations.shelly.formats.gen2 import MAX_ANSWER_BYTES
from homebot.integrations.shelly.formats.gen2_component import COMPONENTS, components_from
from homebot.integrations.shelly.formats.gen2_device import ANSWERS, AnswerKind, is_prefix
from homebot.integrations.shelly.formats.gen2_rpc import CLIENT, Gen2RpcDevice, PartKey, RpcLogin, is_setup_change
from homebot.integrations.shelly.formats.status import Fields
from homebot.support.ble_proxies import BleProxies
from homebot.support.isolation import ungrouped

if TYPE_CHECKING:
    from homebot.gateways.http_client import HttpClient
    from homebot.gateways.http_streams import WebSocket

FrameHandler: TypeAlias = Callable[[Fields, bytes], Awaitable[None]]
"""Receives a frame: parsed, and raw."""

STATUS_INTERVAL_S: Final = 300.0
"""Between requests for the whole status, as a device without measurements may be silent for days."""

FIRST_GENERATION_INTERVAL_S: Final = 18.0
"""Between requests to a device of the first generation, which pushes nothing over HTTP."""

MIN_PAUSE_S: Final = 5.0
"""Between rounds of requests, however often the device reports changes of its setup."""

MAX_BLUETOOTH_SILENCE_S: Final = 24 * 3600.0
"""The silence that a Bluetooth device behind it may have; some send every six hours."""

MAX_ANSWER_S: Final = 15.0
"""For an answer; a Bluetooth operation of a gateway takes several seconds."""

NO_PROXY: Final = "shelly.no_bluetooth_proxy"

UNAUTHORIZED: Final = 401
TRY_LATER: Final = frozenset({-104, -108, -114, 503})
"""Deadline exceeded, resource exhausted, unavailable."""

LOGIN_KEYS: Final = "password_file or password_env in [gateways.mdns.drivers.shelly]"
LOGIN_MISSING: Final = f"it wants a password; give {LOGIN_KEYS}"
LOGIN_WRONG: Final = f"it refuses the password given by {LOGIN_KEYS}"


class ShellyDriverSettings(PasswordSettings, DriverSettings):
    """The passwords of Shelly's devices, for the user ``admin``; its own is for devices without another.

    Attributes:
        devices: Passwords of single devices, by the id that is printed on each: ``shellyplus1-a8032abe54dc``.
    """

    devices: Mapping[str, PasswordSettings] = Field(default_factory=dict)

    def check_secrets(self) -> None:
        """Read all passwords once."""
        self.read_password()
        for device_id in self.devices:
            self.password_of(device_id)

    def password_of(self, device_id: str) -> SecretStr | None:
        """Return the password of a device; None if it has none.

        Raises:
            UsageError: It cannot be read; names the key.
        """
        for name, own in self.devices.items():
            if name.casefold() == device_id.casefold():
                return own.read_password(f"devices.{name}.")
        return self.read_password()


class ShellyDriver(Driver):
    """One Shelly device of the second generation or later; for the first, only model and firmware are listed."""

    service_types: ClassVar[frozenset[str]] = frozenset({"_shelly._tcp.local."})
    Settings: ClassVar[type[DriverSettings]] = ShellyDriverSettings
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)
    settings: ShellyDriverSettings

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        super().__init__(service, settings, host)
        self._device: Gen2RpcDevice | None = None
        self._described: list[GatewayDevice] = []
        self._rpc: RpcLink | None = None
        self._relay: BluetoothRelay | None = None
        self._setup_changed = anyio.Event()
        self._components_known = anyio.Event()

    async def run(self) -> None:
        """Connect, and report the device's states, until cancelled."""

        async def ask(address: str) -> tuple[str, Fields]:
            origin = http_origin(address, self.service.port)
            return origin, as_fields(await client.get_json(f"{origin}/shelly"))

        async with self.http_client(MAX_ANSWER_BYTES) as client:
            origin, about = await first_answer(self.service.name, self.service.addresses, ask)
            if "gen" not in about and "type" in about:
                await self._watch_first_generation(client, origin, about)
            device_id = about.get("id")
            if not isinstance(device_id, str) or not is_prefix(device_id):
                raise WireError(f"{self.service.name} does not answer like a Shelly device")
            async with client.websocket(f"{origin}/rpc", max_bytes=MAX_ANSWER_BYTES) as socket:
                self._device = device = Gen2RpcDevice(device_id)
                device.record_answer("info", about, len(compact_json(about)))
                password = self.settings.password_of(device_id)
                if password is None and about.get("auth_en") is True:
                    self._describe(device)
                    raise RefusedError(device_id, LOGIN_MISSING, UNAUTHORIZED)
                login = None if password is None else RpcLogin(password)
                on_notification = partial(self._on_notification, device)
                self._rpc = rpc = RpcLink(socket, device_id, login, on_notification, self.host.reject)
                try:
                    with ungrouped():
                        async with anyio.create_task_group() as tasks:
                            tasks.start_soon(rpc.receive)
                            if password is not None:
                                tasks.start_soon(self._relay_bluetooth, rpc, about)
                            await self._poll_status(device, rpc)
                except (LinkError, PeerError) as exc:
                    raise rpc.end or exc from None
                finally:
                    self._rpc = None
                    self._components_known.set()

    async def perform(self, command: Command) -> Collection[str]:
        """Carry out a command; return when the device has accepted it."""
        rpc, device = self._rpc, self._device
        if rpc is None or device is None:
            raise LinkError(f"{self.service.name} is not connected")
        values = {setting.capability: setting.value.plain() for setting in command.singly()}
        key = device.id if command.key == self.service.key else command.key
        if key != device.id:
            await self._components_known.wait()
        calls, names = device.calls((key, command.part), values, command.transition)
        for method, params in calls:
            await rpc.call(method, params)
        return names

    async def refresh(self, key: str, part: str) -> None:
        """Read the status of all parts again."""
        del key, part
        rpc, device = self._rpc, self._device
        if rpc is None or device is None:
            raise LinkError(f"{self.service.name} is not connected")
        await rpc.call(ANSWERS["status"], on_answer=partial(self._on_answer, device, "status"))

    async def _watch_first_generation(self, client: HttpClient, origin: str, about: Fields) -> None:
        """Publish the description of the device, which can be used over MQTT, while it answers.

        Source: Shelly Gen1 API, Common HTTP API, /shelly.
        """
        facts: Mapping[str, str] = {
            "manufacturer": "Shelly",
            "model": text_of(about.get("type")),
            "sw_version": text_of(about.get("fw")),
            "generation": "1",
        }
        self.host.describe(
            GatewayDevice(
                self.service.key,
                clean_text(self.service.name),
                metadata={name: value for name, value in facts.items() if value},
                identifiers=identifiers((in_pairs(text_of(about.get("mac"))),)),
            )
        )
        while True:
            await anyio.sleep(FIRST_GENERATION_INTERVAL_S)
            await client.get_json(f"{origin}/shelly")

    async def _poll_status(self, device: Gen2RpcDevice, rpc: RpcLink) -> None:
        """Request the whole status now and then, and at once when the setup of the device has changed."""
        offset = 0

        async def on_components(page: Fields, _frame: bytes) -> None:
            nonlocal offset
            offset = device.add_page(page)
            if offset == 0:
                self._components_known.set()
                self._describe(device)
                await self._report(device.read_status(device.components_status()))

        while True:
            self._setup_changed = anyio.Event()
            for kind, method in ANSWERS.items():
                await rpc.call(method, on_answer=partial(self._on_answer, device, kind))
            offset, asked = 0, -1
            while offset > asked:
                asked = offset
                try:
                    await rpc.call(COMPONENTS, components_from(asked), on_components)
                except RefusedError:  # older firmware has no components that are added
                    self._components_known.set()
            await anyio.sleep(MIN_PAUSE_S)
            with anyio.move_on_after(STATUS_INTERVAL_S):
                await self._setup_changed.wait()

    async def _relay_bluetooth(self, rpc: RpcLink, about: Fields) -> None:
        """Hand over the advertisements that the owner's device hears, if it has the script for that."""
        proxies = self.host.service(BleProxies)  # type: ignore[type-abstract]
        if proxies is None or not proxies.takes_found:
            return
        relay = BluetoothRelay(about)
        try:
            await relay.start(rpc.call, installs=False)
            with relay.attached(proxies.attached):
                self._relay = relay
                await anyio.sleep_forever()
        except (RefusedError, UsageError) as exc:
            self.host.log.info(NO_PROXY, message=f"{self.service.name} is no Bluetooth proxy: {exc}")

    async def _on_answer(self, device: Gen2RpcDevice, kind: AnswerKind, answer: Fields, frame: bytes) -> None:
        device.record_answer(kind, answer, len(frame))
        if kind == "status":
            self._describe(device)
            await self._report(device.read_status(frame))

    async def _on_notification(self, device: Gen2RpcDevice, frame: Fields, payload: bytes) -> None:
        if (self._relay is not None and self._relay.forward(frame)) or not self._described:
            return
        await self.host.deliver_raw(payload)
        await self._report(device.read_notification(payload))
        if is_setup_change(frame):
            self._setup_changed.set()

    async def _report(self, readings_of_parts: Iterable[tuple[PartKey, Readings]]) -> None:
        for (key, part), readings in readings_of_parts:
            await self.host.report(readings, part, self._key_behind(key))

    def _describe(self, device: Gen2RpcDevice) -> None:
        """Publish the descriptions, or only that the device is still there if nothing has changed."""
        if news := device.describe():
            self._described = [
                GatewayDevice(
                    key=self._key_behind(announced.key) or self.service.key,
                    name=announced.name,
                    parts=tuple(row.part.model_copy(update={"reads": (), "writes": ()}) for row in announced.parts),
                    metadata=announced.facts,
                    identifiers=announced.identifiers,
                    stale_after=device.stale_after if announced.implies_alive else MAX_BLUETOOTH_SILENCE_S,
                    sleeps=device.stale_after > 0,
                    expiries={row.part.id: row.expiries for row in announced.parts if row.expiries},
                )
                for announced in news
            ]
        if self._described:
            self.host.describe(self._described[0])
        if self._components_known.is_set():  # on a new link the devices behind it are not gone, only not read yet
            self.host.describe_behind(self._described[1:])

    def _key_behind(self, key: str) -> str:
        """Return the key of a device behind this one; empty for this one."""
        return "" if self._device is None or key == self._device.id else key


class RpcLink:
    """Sends calls and receives answers and notifications over one WebSocket.

    Frames are handled in the order of arrival: an answer reaches its caller before the next notification is handled, so
    that an old status never replaces a newer one. At most three calls run at once, because devices have little memory;
    signed calls run one at a time, because each challenge invalidates the one before.

    Args:
        login: Signs calls; None without a password.
        on_invalid: Called with each invalid frame and the reason.

    Attributes:
        end: The error with which the link was lost; None while it is connected.
    """

    def __init__(
        self,
        socket: WebSocket,
        name: str,
        login: RpcLogin | None,
        on_notification: FrameHandler,
        on_invalid: Callable[[bytes, str], None],
    ) -> None:
        self._socket = socket
        self._name = name
        self._calls = PendingCalls[tuple[Fields, bytes]](name)
        self._login = login
        self._on_notification = on_notification
        self._on_invalid = on_invalid
        self._turns = anyio.Semaphore(3 if login is None else 1)
        self.end: HomebotError | None = None

    async def receive(self) -> None:
        """Handle frames until the link is lost."""
        try:
            await self._socket.receive_all(self._handle_frame, self._on_invalid)
        except HomebotError as exc:
            self.end = exc
            raise
        finally:
            self._calls.end()

    async def call(self, method: str, params: Fields | None = None, on_answer: FrameHandler | None = None) -> None:
        """Call a method.

        Args:
            on_answer: Called with the result and its frame before any later frame is handled.

        Raises:
            LinkError: The link is lost, there was no answer in time, or the device says that it may work later.
            RefusedError: The device refuses, or requires a password, or another one.
            WireError: The answer breaks the rules.
        """
        async with self._turns:
            answer = await self._exchange(method, params, on_answer)
            error = as_fields(answer.get("error"))
            if self._login is not None and error.get("code") == UNAUTHORIZED:
                self._login.accept_challenge(str(error.get("message")))
                answer = await self._exchange(method, params, on_answer)
        if "error" not in answer:
            return
        error = as_fields(answer["error"])
        code, message = error.get("code"), error.get("message")
        what = f"{method} at {self._name}"
        if code == UNAUTHORIZED:
            raise RefusedError(what, LOGIN_MISSING if self._login is None else LOGIN_WRONG, UNAUTHORIZED)
        reason = clean_text(message, 120) if isinstance(message, str) else "the device answered with an error"
        if code in TRY_LATER:
            raise LinkError(f"{what}: {reason}")
        raise RefusedError(what, reason, code if isinstance(code, int) else None)

    async def _exchange(self, method: str, params: Fields | None, on_answer: FrameHandler | None) -> Fields:
        """Send a call, signed if the device has asked for that, and return the frame of the answer."""

        async def send(call_id: str) -> None:
            frame: dict[str, object] = {"id": int(call_id), "src": CLIENT, "method": method}
            if params is not None:
                frame["params"] = params
            if self._login is not None and self._login.is_challenged:
                frame["auth"] = self._login.sign()
            await self._socket.send(compact_json(frame))

        async def handle(answer: tuple[Fields, bytes]) -> None:
            frame, payload = answer
            if on_answer is not None and isinstance(frame.get("result"), dict):
                await on_answer(as_fields(frame["result"]), payload)

        frame, _ = await self._calls.call(method, send, MAX_ANSWER_S, handle)
        return frame

    async def _handle_frame(self, payload: bytes) -> None:
        frame = parse_object(payload, MAX_ANSWER_BYTES)
        if "method" in frame:
            if not isinstance(frame["method"], str):
                raise WireError("the method of a frame is not a text")
            await self._on_notification(frame, payload)
            return
        number = frame.get("id")
        if not isinstance(number, int) or not await self._calls.resolve(str(number), (frame, payload)):
            raise WireError("an answer belongs to no call")
