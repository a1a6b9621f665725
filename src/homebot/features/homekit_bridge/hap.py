"""A bridge of HomeKit by HAP-python; the one file that imports it.

The library serves the connections and keeps the characteristics. What is replaced, as it would not do for a house:
writes are answered once their outcome is known, requests and answers have limits, setup codes cannot be tried without
end, nothing is written to files, and no task outlives :meth:`HapBridge.serve`.

Concurrency: each connection has one request at a time; writes of several run side by side.
"""

from __future__ import annotations

import asyncio
import io
import json
import string
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping
from functools import partial
from hashlib import blake2b
from http import HTTPStatus
from typing import Any, Final, TypeAlias, cast
from urllib.parse import urlparse

import anyio
import anyio.lowlevel
import segno
from anyio.abc import TaskStatus
from anyio.streams.memory import MemoryObjectSendStream
from cryptography.exceptions import InvalidSignature
from pyhap import tlv
from pyhap.accessory import Accessory, Bridge, get_topic
from pyhap.accessory_driver import AccessoryDriver, AccessoryMDNSServiceInfo
from pyhap.characteristic import Characteristic
from pyhap.encoder import AccessoryEncoder
from pyhap.hap_handler import HAP_TLV_STATES, HAP_TLV_TAGS, HAPResponse, HAPServerHandler, UnprivilegedRequestException
from pyhap.hap_protocol import HAPServerProtocol
from pyhap.hap_server import HAPServer
from pyhap.iid_manager import IIDManager
from pyhap.loader import get_loader
from pyhap.util import from_hap_json, generate_pincode, generate_setup_id
from zeroconf import ServiceInfo
from zeroconf.asyncio import AsyncZeroconf

from homebot.clock import Clock
from homebot.devices.names import OWN_MODEL
from homebot.errors import LinkError, WireError
from homebot.features.homekit_bridge.messages import HomekitBridgeInfo
from homebot.features.homekit_bridge.services import HapValue, PartService, Written
from homebot.features.homekit_bridge.setup_code import SetupCodeCheck
from homebot.support.listening import stop_accepting
from homebot.support.own_addresses import own_addresses

OK, REFUSED, NO_RESPONSE, BUSY, READ_ONLY, MISSING, INVALID = 0, -70401, -70402, -70403, -70404, -70409, -70410
"""HAP's status codes (table 6-11)."""

MAX_ACCESSORIES: Final = 149
"""Behind one bridge (6.1: 150 with the bridge itself)."""

MAX_CONNECTIONS: Final = 64
MAX_REQUEST_BYTES: Final = 1 << 20
MAX_UNSENT_BYTES: Final = 4 << 20
MAX_TRIES: Final = 100
"""Wrong setup codes until the next start (5.6.2)."""

_TRY_EVERY_S: Final = 0.1
"""Between two steps of pairings: each takes some milliseconds of arithmetic."""

_PREPARED_S: Final = 60.0
_UNKNOWN_ERROR, _TRIES_ERROR, _PAIRED_ERROR, _BUSY_ERROR = b"\x01", b"\x05", b"\x06", b"\x07"
"""Errors of a pairing (table 5-5)."""

_BASE36: Final = string.digits + string.ascii_uppercase
_BRIDGE_BY_IP: Final = 2 << 4 | 2
"""The category, and the flag of IP, of a setup payload (4.2.2.1)."""

_MAX_JSON_INT: Final = 1 << 53

_BREAKS_RULES: Final = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    InvalidSignature,
    LookupError,
    TypeError,
    ValueError,
)
"""Errors of a request that breaks the rules of HAP, in the library or here: a step out of order, a wrong type."""

OnWrite: TypeAlias = Callable[[Mapping[str, Written]], Awaitable[Mapping[str, int]]]
"""Carries out what was written to services of an accessory, by their keys, and returns HAP's status of each."""


class HapBridge:
    """A bridge.

    Args:
        kept: What :meth:`state` returned in an earlier run; empty for a new bridge.
        on_change: Called when :meth:`state` has changed.

    Attributes:
        lost: What was refused or cut off, by its limit.

    Raises:
        WireError: *kept* is not of a bridge.
    """

    def __init__(
        self,
        name: str,
        address: str,
        port: int,
        clock: Clock,
        kept: Mapping[str, object],
        on_change: Callable[[], object],
        *,
        is_announced: bool,
    ) -> None:
        self._driver = driver = _HapDriver(self, address, port, clock)
        self._is_announced, self._address, self._on_change = is_announced, address, on_change
        self._news = anyio.Event()
        self._accessories: dict[int, _BridgedAccessory] = {}
        self.lost = {"connections": 0, "requests": 0, "answers": 0, "codes": 0}
        if kept:
            try:
                AccessoryEncoder.load_into(io.StringIO(json.dumps(kept["state"])), driver.state)
                driver.state.pincode = str(kept["code"]).encode()
                driver.state.setup_id = str(kept["setup_id"])
            except (KeyError, TypeError, ValueError) as exc:
                raise WireError(f"a kept bridge lacks, or has a wrong, {str(exc)[:40]}") from None
        self._bridge = Bridge(driver, name)
        self._bridge.set_info_service("1.0", "homebot", "Bridge", driver.state.mac)
        driver.accessory = self._bridge

    def state(self) -> dict[str, object]:
        """Return all that it needs to be the same bridge after a restart: keys, pairings, code. A secret."""
        text = io.StringIO()
        state = self._driver.state
        AccessoryEncoder.persist(text, state)
        kept = json.loads(text.getvalue())
        return {"state": kept, "code": state.pincode.decode(), "setup_id": state.setup_id}

    def info(self) -> HomekitBridgeInfo:
        """Return its address, and its code unless it is paired."""
        state = self._driver.state
        number = _BRIDGE_BY_IP << 27 | int(state.pincode.replace(b"-", b""))
        digits = [_BASE36[number // 36**place % 36] for place in reversed(range(9))]
        uri = f"X-HM://{''.join(digits)}{state.setup_id}"
        info = HomekitBridgeInfo(
            name=self._bridge.display_name,
            id=state.mac,
            address=self._address,
            port=state.port,
            accessories=tuple(sorted(one.title for one in self._accessories.values())),
            controllers=len(state.paired_clients),
        )
        if state.paired:
            return info
        qr = tuple("".join(map(str, row)) for row in segno.make(uri, micro=False).matrix)
        return info.model_copy(update={"code": state.pincode.decode(), "uri": uri, "qr": qr})

    def put(self, aid: int, name: str, model: str, services: Iterable[PartService], on_write: OnWrite) -> None:
        """Add an accessory, or replace it; :meth:`describe` tells controllers."""
        self.remove(aid)
        accessory = _BridgedAccessory(self._driver, aid, name, model, services, on_write)
        self._accessories[aid] = accessory
        self._bridge.add_accessory(accessory)

    def remove(self, aid: int) -> None:
        """Remove an accessory; idempotent."""
        if self._accessories.pop(aid, None) is not None:
            del self._bridge.accessories[aid]

    def show(self, aid: int, name: str, values: Mapping[str, Mapping[str, HapValue | None]], *, is_there: bool) -> None:
        """Set the values of an accessory by services and characteristics, and send events for those that changed."""
        self._accessories[aid].show(name, values, is_there=is_there)

    def repeat(self, aid: int, service: str) -> None:
        """Send events with the present values of a service: a controller believes that it has others."""
        self._accessories[aid].repeat(service)

    def describe(self) -> None:
        """Let controllers read the accessories again, if they have changed."""
        driver = self._driver
        if driver.state.set_accessories_hash(driver.accessories_hash):
            self.on_change()

    def on_change(self) -> None:
        """Keep and announce the new state; sessions of controllers without a pairing end."""
        for connection in tuple(self._driver.http_server.connections.values()):
            client = connection.handler.client_uuid
            if client is not None and client not in self._driver.state.paired_clients:
                self._driver.loop.call_soon(connection.close)
        self._on_change()
        self._news.set()

    def unpair(self) -> int:
        """End all pairings, and take another setup code; return how many there were."""
        state = self._driver.state
        count = len(state.paired_clients)
        for client in tuple(state.paired_clients):
            state.paired_clients.pop(client, None)
            state.client_properties.pop(client, None)
            state.uuid_to_bytes.pop(client, None)
        state.pincode, state.setup_id = generate_pincode(), generate_setup_id()
        self.on_change()
        return count

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve controllers until cancelled.

        Raises:
            LinkError: Its address cannot be used.
        """
        driver = self._driver
        driver.aio_stop_event = asyncio.Event()
        server = driver.http_server
        try:
            await server.async_start(driver.loop)
        except OSError as exc:
            where = f"{self._address}, port {driver.state.port}"
            raise LinkError(f"the bridge for HomeKit cannot listen on {where}: {exc.strerror or exc}") from exc
        driver.state.port = server.server.sockets[0].getsockname()[1]
        try:
            driver.to_write, writes = anyio.create_memory_object_stream[Callable[[], Coroutine[Any, Any, None]]](
                MAX_CONNECTIONS
            )
            async with driver.to_write, writes, anyio.create_task_group() as tasks:
                if self._is_announced:
                    await tasks.start(self._announce)
                task_status.started()
                async for write in writes:
                    tasks.start_soon(write)
        finally:
            driver.aio_stop_event.set()
            with anyio.CancelScope(shield=True):
                await stop_accepting(server.server.sockets)
                server.async_stop()
                await anyio.lowlevel.checkpoint()

    async def _announce(self, *, task_status: TaskStatus[None]) -> None:
        driver, anywhere = self._driver, self._address in {"0.0.0.0", "::"}  # noqa: S104 - compared only
        if anywhere:
            driver.state.addresses = own_addresses()
        responder = AsyncZeroconf() if anywhere else AsyncZeroconf(interfaces=[self._address])
        try:
            await (await responder.async_register_service(_info(driver), cooperating_responders=True))
            task_status.started()
            while True:
                await self._news.wait()
                self._news = anyio.Event()
                await (await responder.async_update_service(_info(driver)))
        finally:
            with anyio.CancelScope(shield=True):
                await responder.async_unregister_all_services()
                await responder.async_close()


def _info(driver: AccessoryDriver) -> ServiceInfo:
    info = AccessoryMDNSServiceInfo(driver.accessory, driver.state)
    facts = {**info.properties, b"md": OWN_MODEL}
    addresses = driver.state.addresses
    return ServiceInfo(
        info.type, info.name, info.port, properties=facts, server=info.server, parsed_addresses=addresses
    )


def read_library() -> None:
    """Read the library's descriptions of services from its files."""
    get_loader()


def stable_number(text: str) -> int:
    """Return the number of *text* in HomeKit, the same at each start; 2 and more."""
    return 2 + int.from_bytes(blake2b(text.encode(), digest_size=8).digest()) % (_MAX_JSON_INT - 2)


class _StableIids(IIDManager):  # type: ignore[misc]
    """Numbers of services and characteristics that stay when others come or go; those of the first are 1 and more."""

    def __init__(self) -> None:
        super().__init__()
        self.prefix = ""

    def get_iid_for_obj(self, obj: Any) -> int:
        if not self.prefix:
            return int(super().get_iid_for_obj(obj))
        iid = stable_number(f"{self.prefix}/{obj.type_id}")
        while iid in self.objs:
            iid += 1
        return iid


class _BridgedAccessory(Accessory):  # type: ignore[misc]
    def __init__(
        self,
        driver: AccessoryDriver,
        aid: int,
        name: str,
        model: str,
        services: Iterable[PartService],
        on_write: OnWrite,
    ) -> None:
        iids = _StableIids()
        super().__init__(driver, name, aid=aid, iid_manager=iids)
        self.set_info_service("1.0", "homebot", model or "Device", str(aid))
        self.on_write, self._is_there, self.title = on_write, False, name
        self._characteristics: dict[str, dict[str, Characteristic]] = {}
        self.places: dict[Characteristic, tuple[str, str]] = {}
        self._unknown: set[Characteristic] = set()
        for service in services:
            iids.prefix = service.key
            wanted = service.characteristics()
            hap = driver.loader.get_service(service.kind.name)
            for characteristic in [one for one in hap.characteristics if one.display_name not in wanted]:
                hap.characteristics.remove(characteristic)
            known = {one.display_name for one in hap.characteristics}
            for extra in (*(one for one in wanted if one not in known), *(("Name",) if service.title else ())):
                hap.add_characteristic(driver.loader.get_char(extra))
            if service.title:
                hap.configure_char("Name", value=service.title)
            for characteristic_name, properties in wanted.items():
                characteristic = hap.get_characteristic(characteristic_name)
                valid = cast("dict[str, int] | None", properties.get("ValidValues"))
                bounds = {key: value for key, value in properties.items() if key != "ValidValues"}
                if valid or bounds:
                    if valid:
                        characteristic.value = min(valid.values())
                    characteristic.override_properties(properties=bounds or None, valid_values=valid)
                self._characteristics.setdefault(service.key, {})[characteristic_name] = characteristic
                self.places[characteristic] = service.key, characteristic_name
            self.add_service(hap)
        self._unknown.update(self.places)

    def knows(self, characteristic: Characteristic) -> bool:
        return self._is_there and characteristic not in self._unknown

    def show(self, name: str, values: Mapping[str, Mapping[str, HapValue | None]], *, is_there: bool) -> None:
        self._is_there = is_there
        self.title = name
        self.get_service("AccessoryInformation").get_characteristic("Name").set_value(name)
        for key, characteristics in self._characteristics.items():
            for characteristic_name, characteristic in characteristics.items():
                value = values[key].get(characteristic_name)
                valid = characteristic.properties.get("ValidValues")
                if value is None or (valid and value not in valid.values()):
                    self._unknown.add(characteristic)
                else:
                    self._unknown.discard(characteristic)
                    characteristic.set_value(value)

    def repeat(self, service: str) -> None:
        for characteristic in self._characteristics.get(service, {}).values():
            characteristic.notify()


class _HapDriver(AccessoryDriver):  # type: ignore[misc]
    srp_verifier: SetupCodeCheck | None = None
    """The try that has begun; a property of the library, which has one for itself."""

    def __init__(self, bridge: HapBridge, address: str, port: int, clock: Clock) -> None:
        super().__init__(
            address=address,
            port=port or 1,
            persist_file="",
            loop=asyncio.get_running_loop(),
            loader=get_loader(),
        )
        self.bridge, self.clock = bridge, clock
        self.next_try = 0.0
        self.to_write: MemoryObjectSendStream[Callable[[], Coroutine[Any, Any, None]]] | None = None
        self.http_server = _Server((address, port), self)

    def async_persist(self) -> None:
        """Have the state kept, once the answer is on its way."""
        self.loop.call_soon(self.bridge.on_change)

    def finish_pair(self) -> None:
        """Do nothing: the state was announced when it changed."""

    def setup_srp_verifier(self) -> None:
        """Begin a try of the setup code."""
        self.srp_verifier = SetupCodeCheck(self.state.pincode)

    def register_failed_pairing_attempt(self) -> None:
        """Count a wrong code; the limits are those of :meth:`_Handler.handle_pairing`."""
        self.bridge.lost["codes"] += 1

    def prepare(self, prepare_query: Any, client_addr: Any) -> dict[str, int]:
        """Remember one write to come for each connection."""
        until = self.clock.monotonic() + min(float(prepare_query["ttl"]) / 1000, _PREPARED_S)
        self.prepared_writes[client_addr] = {prepare_query["pid"]: until}
        return {"status": OK}

    def get_characteristics(self, char_ids: list[str]) -> dict[str, list[dict[str, object]]]:
        """Return values; no response for what is away or unknown."""
        rows: list[dict[str, object]] = []
        for text in char_ids:
            aid, iid = (int(number) for number in text.split("."))
            accessory, characteristic = self._find(aid, iid)
            row: dict[str, object] = {"aid": aid, "iid": iid, "status": MISSING}
            if characteristic is not None:
                is_known = accessory is self.accessory or accessory.knows(characteristic)
                row |= {"status": OK, "value": characteristic.get_value()} if is_known else {"status": NO_RESPONSE}
            rows.append(row)
        return {"characteristics": rows}

    def begin_write(self, request: Any, client: Any, response: HAPResponse) -> asyncio.Future[bytes]:
        """Return the future body of *response*, which gets its status with it."""
        future: asyncio.Future[bytes] = self.loop.create_future()
        try:
            if self.to_write is not None:
                self.to_write.send_nowait(partial(self._write, request, client, response, future))
        except (anyio.WouldBlock, anyio.ClosedResourceError):
            self.bridge.lost["answers"] += 1
            future.cancel()  # which is answered as a failure
        return future

    async def _write(self, request: Any, client: Any, response: HAPResponse, body: asyncio.Future[bytes]) -> None:
        try:
            rows = await self._written(request, client)
        except _BREAKS_RULES:
            response.status_code, response.reason = 400, "Bad Request"
            rows = []
        if any(row["status"] for row in rows):
            response.status_code, response.reason = 207, "Multi-Status"
            response.headers.append(("Content-Type", "application/hap+json"))
        if not body.done():
            body.set_result(json.dumps({"characteristics": rows}).encode() if response.headers else b"")

    async def _written(self, request: Any, client: Any) -> list[dict[str, Any]]:
        """Carry out subscriptions and writes, and return the status of each."""
        pid = request.get("pid")
        until = self.prepared_writes.get(client, {}).pop(pid, 0.0) if pid is not None else 0.0
        is_late = pid is not None and self.clock.monotonic() > until
        rows: list[dict[str, Any]] = []
        wanted: dict[int, dict[str, dict[str, HapValue]]] = {}
        places: list[tuple[dict[str, Any], int, str]] = []
        for query in request["characteristics"]:
            aid, iid = query["aid"], query["iid"]
            accessory, characteristic = self._find(aid, iid)
            row = {"aid": aid, "iid": iid, "status": MISSING if characteristic is None else OK}
            rows.append(row)
            if characteristic is None:
                continue
            if "ev" in query:
                self.async_subscribe_client_topic(client, get_topic(aid, iid), bool(query["ev"]))
            if "value" not in query:
                continue
            place = getattr(accessory, "places", {}).get(characteristic)
            if place is None or "pw" not in characteristic.properties["Permissions"]:
                row["status"] = READ_ONLY
            elif is_late:
                row["status"] = INVALID
            else:
                try:
                    value = characteristic.to_valid_value(query["value"])
                    characteristic.valid_value_or_raise(value)
                except (TypeError, ValueError):
                    row["status"] = INVALID
                    continue
                wanted.setdefault(aid, {}).setdefault(place[0], {})[place[1]] = value
                places.append((row, aid, place[0]))
        statuses: dict[int, Mapping[str, int]] = {}

        async def write(aid: int, written: Mapping[str, Written], on_write: OnWrite) -> None:
            statuses[aid] = await on_write(written)

        async with anyio.create_task_group() as tasks:
            for aid, written in wanted.items():
                tasks.start_soon(write, aid, written, self.accessory.accessories[aid].on_write)
        for row, aid, service in places:
            row["status"] = statuses[aid][service]
        return rows

    def _find(self, aid: int, iid: int) -> tuple[Any, Characteristic | None]:
        accessory = self.accessory if aid == self.accessory.aid else self.accessory.accessories.get(aid)
        found = None if accessory is None else accessory.get_characteristic(aid, iid)
        return accessory, found if isinstance(found, Characteristic) else None


class _Server(HAPServer):  # type: ignore[misc]
    def __init__(self, place: tuple[str, int], driver: _HapDriver) -> None:
        super().__init__(place, driver)
        self._place = place

    async def async_start(self, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        connect = partial(_Protocol, loop, self.connections, self.accessory_handler)
        self.server = await loop.create_server(connect, *self._place)
        self.async_cleanup_connections()


class _Handler(HAPServerHandler):  # type: ignore[misc]
    def dispatch(self, request: Any, body: bytes | None = None) -> HAPResponse:
        """Answer a request; one that breaks the rules is refused and counted, and is no failure of the bridge."""
        self.response = response = HAPResponse()
        self.request_body = body
        try:
            self.parsed_url = urlparse(request.target.decode())
            handle = self.HANDLERS.get(request.method.decode(), {}).get(self.parsed_url.path)
            if handle is None:
                self.send_response_with_status(HTTPStatus.NOT_FOUND, MISSING)
            else:
                getattr(self, handle)()
        except UnprivilegedRequestException:
            self.send_response_with_status(HTTPStatus.UNAUTHORIZED, REFUSED)
        except _BREAKS_RULES:
            self.accessory_handler.bridge.lost["requests"] += 1
            self.send_response_with_status(HTTPStatus.BAD_REQUEST, INVALID)
        self.response = None
        return response

    def handle_set_characteristics(self) -> None:
        """Begin a write; the answer is that of its outcome."""
        if not self.is_encrypted:
            raise UnprivilegedRequestException
        request = from_hap_json(self.request_body)
        self.response.status_code, self.response.reason = 204, "No Content"
        self.response.task = self.accessory_handler.begin_write(request, self.client_address, self.response)

    def handle_pairing(self) -> None:
        """Take a step of a pairing: in its order, and at a limited rate."""
        driver, now = self.accessory_handler, self.accessory_handler.clock.monotonic()
        step = tlv.decode(self.request_body)[HAP_TLV_TAGS.SEQUENCE_NUM]
        code_check = driver.srp_verifier
        error, status = b"", HTTPStatus.OK
        if self.state.paired:
            error = _PAIRED_ERROR
        elif driver.bridge.lost["codes"] >= MAX_TRIES:
            error = _TRIES_ERROR
        elif step == HAP_TLV_STATES.M1:
            error = _BUSY_ERROR if now < driver.next_try else b""
            driver.next_try = max(driver.next_try, now + _TRY_EVERY_S)
        elif code_check is None or step not in {HAP_TLV_STATES.M3, HAP_TLV_STATES.M5}:
            error, status = _UNKNOWN_ERROR, HTTPStatus.BAD_REQUEST
        elif step == HAP_TLV_STATES.M3 and code_check.is_used:
            error = _BUSY_ERROR  # one try for each beginning
        if error:
            self.send_response(status)
            self.send_header("Content-Type", self.PAIRING_RESPONSE_TYPE)
            data = (HAP_TLV_TAGS.SEQUENCE_NUM, bytes([step[0] + 1 & 0xFF]), HAP_TLV_TAGS.ERROR_CODE, error)
            self.end_response(tlv.encode(*data))
            return
        super().handle_pairing()


class _Protocol(HAPServerProtocol):  # type: ignore[misc]
    """A connection, with limits; one that exceeds them is cut off and counted."""

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self.handler = _Handler(self.accessory_driver, self.peername)
        self._unread = 0
        if len(self.connections) > MAX_CONNECTIONS:
            self._cut("connections")

    def data_received(self, data: bytes) -> None:
        self._unread = self._unread + len(data) if self.response is not None else 0
        if self._unread <= MAX_REQUEST_BYTES:
            super().data_received(data)
        if sum(map(len, self.request_body)) + self._unread > MAX_REQUEST_BYTES:
            self._cut("requests")

    def write(self, data: bytes) -> None:
        super().write(data)
        if self.transport.get_write_buffer_size() > MAX_UNSENT_BYTES:
            self._cut("answers")

    def _cut(self, what: str) -> None:
        self.accessory_driver.bridge.lost[what] += 1
        self.transport.abort()
