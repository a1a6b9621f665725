"""The port to accessories by aiohomekit, which has the cryptography and the framing; the one file that imports it.

The library's own pairing connects again by itself, repeats what was written as if it were an event, and goes on sending
after a cancelled request. So its connection is used, and closed in one piece when it is lost, or too late.
"""

from __future__ import annotations

import contextlib
import socket
import struct
from collections.abc import AsyncIterator, Iterable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from itertools import groupby
from typing import Any, Final

import anyio
from aiohomekit import exceptions, hkjson
from aiohomekit.characteristic_cache import CharacteristicCacheMemory
from aiohomekit.controller.ip.connection import SecureHomeKitConnection
from aiohomekit.controller.ip.controller import IpController
from aiohomekit.controller.ip.discovery import IpDiscovery
from aiohomekit.model import Categories
from aiohomekit.model.feature_flags import FeatureFlags
from aiohomekit.model.status_flags import StatusFlags
from aiohomekit.protocol.tlv import TLV
from aiohomekit.zeroconf import HAP_TYPE_TCP, HomeKitService

from homebot.conventions.homekit.accessory import CharacteristicId
from homebot.conventions.payload import as_fields, clean_text
from homebot.errors import LinkError, RefusedError, WireError, WrongCodeError
from homebot.gateways.homekit.port import FoundAccessory, HomekitLink, HomekitPort, OnEvent, Pairing, StatusCodes
from homebot.support.numbers import whole_number

__all__ = ["AiohomekitPort"]

CONNECTS_WITHIN, ANSWERS_WITHIN, PAIRS_WITHIN = 10.0, 8.0, 60.0
"""Seconds; small processors take some for the keys of a connection, and half a minute for those of a pairing."""

READ_AT_ONCE: Final = 40
"""Characteristics in one request: some accessories take short addresses only."""

_PREPARED: Final = 5000
"""Milliseconds in which a timed write has to follow its announcement."""

_NO_LINGER: Final = struct.pack("ii", 1, 0)


class _Owner:
    """The pairing that the library's connection reports to."""

    description = None

    def __init__(self, name: str, on_event: OnEvent) -> None:
        self.name = name
        self.event_received = on_event

    async def connection_made(self, secure: bool) -> None:  # noqa: FBT001 - the library calls it so
        """Do nothing: the connection is used by its opener."""


class _Connection(SecureHomeKitConnection):
    """A connection that is not made again when it is lost."""

    def __init__(self, owner: _Owner, pairing: dict[str, Any]) -> None:
        super().__init__(owner, pairing)  # type: ignore[arg-type]
        self.lost = anyio.Event()

    def _connection_lost(self, exception: Exception) -> None:
        self.closing = True
        super()._connection_lost(exception)
        self.lost.set()

    def abort(self) -> None:
        """Close at once: bytes that are not yet sent are dropped, also those in the system's buffer."""
        self.closing = True
        if self.transport is not None:
            opened = self.transport.get_extra_info("socket")
            with contextlib.suppress(OSError):
                opened.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)
            self.transport.abort()
        self.lost.set()


class _AccessoryLink(HomekitLink):
    def __init__(self, name: str, connection: _Connection, controller_id: str) -> None:
        self.lost = connection.lost
        self._name = name
        self._connection = connection
        self._controller_id = controller_id

    async def list_accessories(self) -> object:
        async with self._asking():
            return await self._connection.get_json("/accessories")

    async def read(self, ids: Iterable[CharacteristicId]) -> object:
        async with self._asking():
            return await self._connection.get_json(
                "/characteristics?id=" + ",".join(f"{aid}.{iid}" for aid, iid in ids)
            )

    async def write(self, values: Mapping[CharacteristicId, object], *, is_timed: bool) -> StatusCodes:
        body: dict[str, object] = {
            "characteristics": [{"aid": aid, "iid": iid, "value": value} for (aid, iid), value in values.items()]
        }
        async with self._asking():
            if is_timed:
                body["pid"] = 1
                await self._connection.put_json("/prepare", {"ttl": _PREPARED, "pid": 1})
            return _statuses(await self._connection.put_json("/characteristics", body), tuple(values))

    async def subscribe(self, ids: Iterable[CharacteristicId]) -> None:
        for _, of_one in groupby(sorted(ids), lambda one: one[0]):  # one accessory at a time, as iOS does
            body = {"characteristics": [{"aid": aid, "iid": iid, "ev": True} for aid, iid in of_one]}
            async with self._asking():
                await self._connection.put_json("/characteristics", body)

    async def unpair(self) -> None:
        request = [
            (TLV.kTLVType_State, TLV.M1),
            (TLV.kTLVType_Method, TLV.RemovePairing),
            (TLV.kTLVType_Identifier, self._controller_id.encode()),
        ]
        async with self._asking():
            await self._connection.post_tlv("/pairings", request)

    @asynccontextmanager
    async def _asking(self) -> AsyncIterator[None]:
        """Ask within a time limit; a request without an answer ends the connection, and is not sent any more."""
        try:
            with _translated(self._name), anyio.fail_after(ANSWERS_WITHIN):
                yield
        except (LinkError, anyio.get_cancelled_exc_class()):
            self._connection.abort()
            raise


class AiohomekitPort(HomekitPort):
    """Accessories on the local network, by TCP."""

    @asynccontextmanager
    async def connected(self, found: FoundAccessory, pairing: Pairing, on_event: OnEvent) -> AsyncIterator[HomekitLink]:
        """Connect to a paired accessory."""
        keys = {**pairing, "AccessoryIPs": [found.address], "AccessoryIP": found.address, "AccessoryPort": found.port}
        connection = _Connection(_Owner(found.name, on_event), keys)
        try:
            with _translated(found.name), anyio.fail_after(CONNECTS_WITHIN):
                await connection._connect_once()  # type: ignore[no-untyped-call]  # noqa: SLF001 - the public method goes on trying by itself
            yield _AccessoryLink(found.name, connection, str(pairing.get("iOSPairingId")))
        finally:
            connection.abort()

    async def pair(self, found: FoundAccessory, digits: str) -> Pairing:
        """Pair with an accessory."""
        controller = IpController(CharacteristicCacheMemory(), None)  # type: ignore[arg-type]  # it finds nothing
        discovery = IpDiscovery(controller, _service_of(found))
        try:
            with _translated(found.name), anyio.fail_after(PAIRS_WITHIN):
                await discovery.connection._connect_once()  # noqa: SLF001 - likewise
                finish = await discovery.async_start_pairing(found.id)
                return dict((await finish(digits))._pairing_data)  # noqa: SLF001 - of each kind of pairing
        finally:
            with anyio.CancelScope(shield=True):
                await discovery.close()  # type: ignore[no-untyped-call]


def _service_of(found: FoundAccessory) -> HomeKitService:
    return HomeKitService(
        name=found.name,
        id=found.id,
        model=found.model,
        feature_flags=FeatureFlags(found.features),
        status_flags=StatusFlags.UNPAIRED,
        config_num=1,
        state_num=1,
        category=Categories.OTHER,
        protocol_version="1.1",
        type=HAP_TYPE_TCP,
        address=found.address,
        addresses=[found.address],
        port=found.port,
    )


def _statuses(answer: object, written: tuple[CharacteristicId, ...]) -> StatusCodes:
    """Return the status codes that are not 0; one for all counts for each."""
    fields = as_fields(answer)
    status, listed = whole_number(fields.get("status")) or 0, fields.get("characteristics")
    found = dict.fromkeys(written, status) if status else {}
    for one in map(as_fields, listed if isinstance(listed, list) else ()):
        aid, iid, code = (whole_number(one.get(name)) for name in ("aid", "iid", "status"))
        if aid is not None and iid is not None and code:
            found[aid, iid] = code
    return found


_REFUSALS: Final = (
    (exceptions.UnavailableError, "it is paired with another controller; remove it there, or reset it"),
    (exceptions.MaxPeersError, "it has as many pairings as it can keep"),
    (exceptions.MaxTriesError, "too many wrong codes were tried; disconnect its power for a moment"),
    (exceptions.BusyError, "another controller is pairing with it"),
    (exceptions.BackoffError, "it wants a pause after a wrong code; try again later"),
    (exceptions.InvalidError, "it does not know homebot any more, or is no accessory; pair it again"),
    (exceptions.HttpErrorResponse, "it refuses the request"),
)


@contextmanager
def _translated(name: str) -> Iterator[None]:
    """Turn the library's errors into ours; no error shows a code or a key."""
    try:
        yield
    except exceptions.AuthenticationError:
        reason = "the code is wrong, or the pairing was removed there; pair it again"
        raise WrongCodeError(f"the connection to {name}", reason) from None
    except tuple(kind for kind, _ in _REFUSALS) as exc:
        reason = next(text for kind, text in _REFUSALS if isinstance(exc, kind))
        raise RefusedError(f"the connection to {name}", reason) from None
    except (exceptions.AccessoryDisconnectedError, OSError, TimeoutError) as exc:
        reason = clean_text(str(exc)) or "it does not answer in time"
        raise LinkError(f"{name} cannot be reached: {reason}") from None
    except (exceptions.HomeKitException, *hkjson.JSON_DECODE_EXCEPTIONS, IndexError, KeyError) as exc:
        raise WireError(f"{name} does not follow the HomeKit Accessory Protocol ({type(exc).__name__})") from None
