"""The port to accessories through aiohomekit, which provides cryptography and framing; the only file that imports it.

The library would reconnect, repeat a written value as an event, and keep sending after a cancelled request. So each
connection is used once, and closed completely when it is lost or an answer is late.
"""

import asyncio
import os
import socket
import struct
import sys
from abc import abstractmethod
from collections.abc import AsyncIterator, Iterable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any, Final

import anyio
from aiohomekit import exceptions
from aiohomekit.characteristic_cache import CharacteristicCacheMemory
from aiohomekit.controller.coap.controller import CoAPController
from aiohomekit.controller.coap.discovery import CoAPDiscovery
from aiohomekit.controller.ip.controller import IpController
from aiohomekit.controller.ip.discovery import IpDiscovery
from aiohomekit.controller.ip.pairing import format_characteristic_list
from aiohomekit.model import Categories
from aiohomekit.model.feature_flags import FeatureFlags
from aiohomekit.model.status_flags import StatusFlags
from aiohomekit.zeroconf import HomeKitService

from homebot.conventions.payload import clean_text
from homebot.errors import HomebotError, LinkError, RefusedError, WireError, WrongCodeError
from homebot.integrations.homekit.formats.accessory import CharacteristicId
from homebot.integrations.homekit.gateway.port import (
    PAIRS_WITHIN,
    FoundAccessory,
    HomekitLink,
    HomekitPort,
    HomekitValues,
    OnEvent,
    Pairing,
    StatusCodes,
)
from homebot.support.numbers import whole_number
from homebot.support.unanswered import awaiting_answer

if sys.platform == "linux":  # otherwise it also listens on TCP and WebSocket, for each accessory over Thread
    os.environ.setdefault("AIOCOAP_SERVER_TRANSPORT", "udp6")

READ_AT_ONCE: Final = 40
"""Most characteristics in one request over IP, as some accessories only accept short addresses."""

_PREPARED: Final = 5000
"""Milliseconds within which a timed write must follow its announcement."""


class _PairedLink(HomekitLink):
    """A connection by a pairing of the library, which answers within so many seconds."""

    answers_within: float

    def __init__(self, name: str, pairing: Any, on_event: OnEvent) -> None:
        self.lost = anyio.Event()
        self._name = name
        self._pairing = pairing
        self._connection = pairing.connection
        pairing.dispatcher_connect(on_event)

    @abstractmethod
    async def open(self, within: float) -> None:
        """Connect; *within* so many seconds, over IP."""

    @abstractmethod
    async def close(self) -> None:
        """Close at once, without sending requests that are still queued."""

    async def list_accessories(self) -> object:
        async with self._asking():
            return await self._pairing.list_accessories_and_characteristics()

    async def read(self, ids: Iterable[CharacteristicId]) -> HomekitValues:
        async with self._asking():
            return dict(await self._pairing.get_characteristics(ids))

    async def subscribe(self, ids: Iterable[CharacteristicId]) -> None:
        async with self._asking():
            await self._pairing.subscribe(sorted(ids))

    async def unpair(self) -> None:
        async with self._asking():
            await self._pairing.remove_pairing(str(self._pairing.pairing_data.get("iOSPairingId")))

    @asynccontextmanager
    async def _asking(self) -> AsyncIterator[None]:
        """Limit the time for an answer; without one the connection is closed."""
        if self.lost.is_set():  # the library would open a new one
            raise LinkError(f"{self._name} cannot be reached: the connection was lost")
        try:
            with awaiting_answer(), _translate(self._name), anyio.fail_after(self.answers_within):
                yield
        except (LinkError, anyio.get_cancelled_exc_class()):
            with anyio.CancelScope(shield=True):
                await self.close()
            raise


class _IpLink(_PairedLink):
    """A connection by TCP."""

    answers_within = 20.0
    """Homebridge waits 9 s for a plug-in that hangs (HAP-NodeJS, ``TIMEOUT_WARNING`` and ``TIMEOUT_AFTER_WARNING``);
    the library sends a command only after the answer to a reading."""

    _transport: asyncio.Transport | None = None

    async def open(self, within: float) -> None:
        await _connect(self._connection, within)
        self._connection.closing = True  # it is not reopened
        self._transport = transport = self._connection.transport
        linger = struct.pack("ii", 1, 0)  # closing drops whatever the system could not send yet
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        transport.set_protocol(_LossWatch(transport.get_protocol(), self.lost))

    async def close(self) -> None:
        if self._transport is not None:
            self._transport.abort()
        self.lost.set()
        with suppress(exceptions.HomeKitException):  # the reason for a failure to open
            await self._pairing.close()

    async def read(self, ids: Iterable[CharacteristicId]) -> HomekitValues:
        waiting, values = list(ids), dict[CharacteristicId, Mapping[str, object]]()
        for start in range(0, len(waiting), READ_AT_ONCE):
            values |= await super().read(waiting[start : start + READ_AT_ONCE])
        return values

    async def write(self, values: Mapping[CharacteristicId, object], *, is_timed: bool) -> StatusCodes:
        body: dict[str, object] = {
            "characteristics": [{"aid": aid, "iid": iid, "value": value} for (aid, iid), value in values.items()]
        }
        async with self._asking():
            if is_timed:
                body["pid"] = 1
                await self._connection.put_json("/prepare", {"ttl": _PREPARED, "pid": 1})
            answer = await self._connection.put_json("/characteristics", body)
            return _statuses(format_characteristic_list(answer, set(values)))


class _LossWatch(asyncio.Protocol):
    """The library's protocol of a connection, which also sets an event when the connection is lost."""

    def __init__(self, protocol: asyncio.Protocol, lost: anyio.Event) -> None:
        self.data_received, self.eof_received = protocol.data_received, protocol.eof_received  # type: ignore[method-assign]
        self._protocol = protocol
        self._lost = lost

    def connection_lost(self, exc: Exception | None) -> None:
        self._protocol.connection_lost(exc)
        self._lost.set()


class _ThreadLink(_PairedLink):
    """A session over CoAP; it is lost if a request is not answered."""

    answers_within = 120.0
    """A description takes a message for each service, and each some seconds if the accessory sleeps; the library waits
    16 s for an answer."""

    def __init__(self, name: str, pairing: Any, on_event: OnEvent) -> None:
        super().__init__(name, pairing, self._on_event)
        self._relay = on_event
        self._written: set[CharacteristicId] = set()

    async def open(self, within: float) -> None:
        del within  # the library waits 8 s for each answer
        await self._connection.connect(self._pairing.pairing_data)

    async def close(self) -> None:
        self.lost.set()
        if self._connection.is_connected:
            await self._connection.reconnect_soon()  # which only closes it

    async def write(self, values: Mapping[CharacteristicId, object], *, is_timed: bool) -> StatusCodes:
        del is_timed  # the library writes in one step here
        self._written |= values.keys()
        try:
            async with self._asking():
                written = [(aid, iid, value) for (aid, iid), value in values.items()]
                return _statuses(await self._pairing.put_characteristics(written))
        finally:
            self._written -= values.keys()

    def _on_event(self, values: HomekitValues) -> None:
        """Relay the reports of the accessory, but not the library's repetitions of a write."""
        self._relay({key: value for key, value in values.items() if key not in self._written})


class AiohomekitPort(HomekitPort):
    """Accessories on the local network, over TCP within *connects_within* seconds, or over Thread by CoAP."""

    def __init__(self, connects_within: float = 10.0) -> None:
        self._connects_within = connects_within

    @asynccontextmanager
    async def connected(
        self, sighted: FoundAccessory, pairing: Pairing, on_event: OnEvent
    ) -> AsyncIterator[HomekitLink]:
        """Connect to a paired accessory."""
        address = {"AccessoryIP": sighted.address, "AccessoryIPs": [sighted.address], "AccessoryPort": sighted.port}
        name = "CoAP" if sighted.is_on_thread else "IP"
        with _translate(sighted.name):
            loaded = _controller_of(sighted).load_pairing(sighted.id, {**pairing, **address, "Connection": name})
            link = (_ThreadLink if sighted.is_on_thread else _IpLink)(sighted.name, loaded, on_event)
        try:
            with _translate(sighted.name):
                await link.open(self._connects_within)
            yield link
        finally:
            with anyio.CancelScope(shield=True):
                await link.close()

    async def pair(self, sighted: FoundAccessory, digits: str) -> Pairing:
        """Pair with an accessory."""
        kind: Any = CoAPDiscovery if sighted.is_on_thread else IpDiscovery
        discovery = kind(_controller_of(sighted), _service_of(sighted))
        try:
            with _translate(sighted.name, is_pairing=True), anyio.fail_after(PAIRS_WITHIN):
                if not sighted.is_on_thread:
                    await _connect(discovery.connection, self._connects_within)
                finish = await discovery.async_start_pairing(sighted.id)
                return dict((await finish(digits)).pairing_data)
        finally:
            with anyio.CancelScope(shield=True):
                await discovery.close()


def _controller_of(sighted: FoundAccessory) -> Any:
    """Return a controller that finds nothing by itself: the mDNS gateway does."""
    kind: Any = CoAPController if sighted.is_on_thread else IpController
    return kind(CharacteristicCacheMemory(), None)


async def _connect(connection: Any, within: float) -> None:
    """Open a TCP connection; the library retries within the time limit, and forgets the last error at each attempt."""
    errors: list[Exception] = []
    attempt = connection._connect_once  # noqa: SLF001 - the library has no public way

    async def attempt_and_note() -> None:
        try:
            await attempt()
        except Exception as exc:
            errors.append(exc)
            raise

    connection._connect_once = attempt_and_note  # noqa: SLF001
    with anyio.move_on_after(within):
        await connection.ensure_connection()
    if not connection.is_connected:
        raise errors[-1] if errors else TimeoutError


def _service_of(sighted: FoundAccessory) -> HomeKitService:
    return HomeKitService(
        name=sighted.name,
        id=sighted.id,
        model=sighted.model,
        feature_flags=FeatureFlags(sighted.features),
        status_flags=StatusFlags.UNPAIRED,
        config_num=1,
        state_num=1,
        category=Categories.OTHER,
        protocol_version="1.1",
        type=f"{sighted.service_type}.local.",
        address=sighted.address,
        addresses=[sighted.address],
        port=sighted.port,
    )


def _statuses(answer: HomekitValues) -> StatusCodes:
    statuses = {key: whole_number(result.get("status")) for key, result in answer.items()}
    return {key: status for key, status in statuses.items() if status}


_FORGOTTEN: Final = "it does not know homebot any more; pair it again"
_PAIRING_REFUSALS: Final[Mapping[type[Exception], str]] = {
    # HAP-python 5.0.0 (hsrp.py), the bridge of Home Assistant, drops leading zeros: it refuses 1 % of the right codes.
    exceptions.AuthenticationError: "the code is wrong; if you are sure of it, try once more",
    exceptions.UnavailableError: "it is paired with another controller; remove it there, or reset it",
    exceptions.MaxPeersError: "it has as many pairings as it can keep",
    exceptions.MaxTriesError: "too many wrong codes were tried; disconnect its power for a moment",
    exceptions.BusyError: "another controller is pairing with it",
    exceptions.BackoffError: "it wants a pause after a wrong code; try again later",
    exceptions.InvalidError: "it refuses the request",
    exceptions.HttpErrorResponse: "it refuses the request",
}
_REFUSALS: Final = {
    **_PAIRING_REFUSALS,
    exceptions.AuthenticationError: _FORGOTTEN,
    exceptions.InvalidError: _FORGOTTEN,
}
_LOST: Final = (exceptions.AccessoryDisconnectedError, exceptions.EncryptionError, OSError, TimeoutError)
"""A restarted accessory has lost the keys of its sessions over Thread."""


@contextmanager
def _translate(name: str, *, is_pairing: bool = False) -> Iterator[None]:
    """Turn the library's errors into ours; no error shows a code or a key."""
    try:
        yield
    except Exception as exc:  # noqa: BLE001 - it trusts the accessory, and fails in any way if that breaks the rules
        raise _error_of(name, exc, is_pairing=is_pairing) from None


def _error_of(name: str, error: Exception, *, is_pairing: bool) -> HomebotError:
    what, causes = f"{'pairing' if is_pairing else 'the connection to'} {name}", tuple(_causes(error))
    for kind, reason in (_PAIRING_REFUSALS if is_pairing else _REFUSALS).items():
        if any(isinstance(cause, kind) for cause in causes):
            is_wrong = is_pairing and kind is exceptions.AuthenticationError
            return WrongCodeError(what, reason) if is_wrong else RefusedError(what, reason)
    if isinstance(error, _LOST):
        return LinkError(f"{name} cannot be reached: {clean_text(str(error)) or 'it did not answer in time'}")
    return WireError(f"{name} does not follow the HomeKit Accessory Protocol ({type(error).__name__})")


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error and the errors behind it: over Thread, the library hides the reason."""
    while error is not None:
        yield error
        error = error.__context__
