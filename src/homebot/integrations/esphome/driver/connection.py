"""A connection to an ESPHome device; the only file that imports aioesphomeapi.

The library handles framing, encryption (Noise) and pings: the connection to a device that is silent for 26 seconds is
lost.
"""

import asyncio
import codecs
import socket
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import AbstractContextManager, asynccontextmanager, contextmanager

import anyio
from aioesphomeapi import core, model
from aioesphomeapi.api_pb2 import BluetoothLERawAdvertisementsResponse  # type: ignore[attr-defined] # made when imported
from aioesphomeapi.client import APIClient
from aioesphomeapi.model_conversions import STATE_TYPE_TO_INFO_TYPE
from pydantic import SecretStr

from homebot.conventions.entity_rows import Fields
from homebot.conventions.payload import clean_text
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.drivers.base import first_answer
from homebot.integrations.esphome.driver.settings import KEY_ADVICE, PASSWORD_ADVICE, PLAIN_ADVICE
from homebot.integrations.esphome.formats.device import ListedEntity
from homebot.support.ble_proxies import ProxyGate
from homebot.support.limits import RateLimit

PING_EVERY = 4.0
"""Seconds of silence, at most twice as many, after which the device is pinged; the library then waits 4.5 times as long
for anything to come."""

_COMPONENTS: Mapping[type, str] = {info: kind for kind, info in model.COMPONENT_TYPE_TO_INFO.items()}
_STATES: Mapping[type, str] = {state: _COMPONENTS[info] for state, info in STATE_TYPE_TO_INFO_TYPE.items()}

codecs.lookup("idna")  # getaddrinfo uses it; its first use loads a module: here, and not while the event loop runs

RECEIVED_AT_ONCE = 8 * 1024
"""Bytes; Linux takes twice that. All that came is handled without a pause, and 256 KiB of tiny frames take a second."""

BURST, PER_SECOND = 512 * 1024, 64 * 1024
"""Bytes that may come at once, and each second after that: the entity list of a large device, and a hundred times
its reports. More keeps homebot busy, and each ping is answered, whether the device reads the answers or not."""

CONNECT_WITHIN = 10.0
"""Seconds for a connection."""


class GatedClient(APIClient):
    """The library's client, which lets the advertisements that a device hears through a gate.

    Attributes:
        gate: Lets none through while it is None.
    """

    gate: ProxyGate | None = None
    _on_advertisements: Callable[[BluetoothLERawAdvertisementsResponse], None]

    def subscribe_bluetooth_le_raw_advertisements(
        self, on_advertisements: Callable[[BluetoothLERawAdvertisementsResponse], None]
    ) -> Callable[[], None]:
        """Subscribe to advertisements; a further call only repeats the request, as the library wants it."""
        self._on_advertisements = on_advertisements
        return super().subscribe_bluetooth_le_raw_advertisements(self._forward_admitted)

    def _forward_admitted(self, message: BluetoothLERawAdvertisementsResponse) -> None:
        gate = self.gate
        if gate is not None:
            heard = message.advertisements
            passed = [one for one in heard if gate.admits(one.address, one.rssi, len(one.data))]
            if len(passed) < len(heard):
                message = BluetoothLERawAdvertisementsResponse(advertisements=passed)
            self._on_advertisements(message)


class EsphomeConnection:
    """An open connection; see :func:`connected`.

    Attributes:
        info: The facts of the device, once they are read.
    """

    info: model.DeviceInfo

    def __init__(self, name: str, client: GatedClient) -> None:
        self.name = name
        self.client = client
        self.lost = anyio.Event()

    async def describe(self) -> tuple[Fields, list[ListedEntity]]:
        """Return the facts of the device, and its entities."""
        await self.learn()
        with _translated(self.name):
            entities, _ = await self.client.list_entities_services()
        version = self.client.api_version or model.APIVersion()
        return self.info.to_dict(), [
            (_COMPONENTS[type(entity)], _with_compatible(entity, version))
            for entity in entities
            if type(entity) in _COMPONENTS
        ]

    async def learn(self) -> None:
        """Read the facts of the device."""
        with _translated(self.name):
            self.info = await self.client.device_info()

    @property
    def is_bluetooth_proxy(self) -> bool:
        """True if it relays Bluetooth advertisements as they are, as firmware since 2023.6 does."""
        features = self.info.bluetooth_proxy_feature_flags_compat(self.client.api_version or model.APIVersion())
        return bool(features & model.BluetoothProxyFeature.RAW_ADVERTISEMENTS)

    def translated(self) -> AbstractContextManager[None]:
        """Turn the library's errors inside the block into homebot's."""
        return _translated(self.name)

    def subscribe(self, on_state: Callable[[str, Fields], None]) -> None:
        """Subscribe to all states: the current ones first, then each change, as component and fields."""

        def on_message(state: model.EntityState) -> None:
            kind = _STATES.get(type(state))
            if kind is not None and kind != "camera":
                on_state(kind, state.to_dict())

        with _translated(self.name):
            self.client.subscribe_states(on_message)

    def send(self, kind: str, key: tuple[int, int], fields: Fields) -> None:
        """Send the command of an entity, which the native API does not answer."""
        device_id, number = key
        command = getattr(self.client, f"{kind}_command")
        with _translated(self.name):
            command(number, device_id=device_id, **fields)

    async def on_stop(self, _expected: bool) -> None:  # noqa: FBT001 - the library calls it so
        """Record that the connection ended."""
        self.lost.set()


@asynccontextmanager
async def connected(
    name: str, addresses: tuple[str, ...], port: int, key: SecretStr | None, password: SecretStr | None
) -> AsyncIterator[EsphomeConnection]:
    """Connect to a device at the best address that answers, and close at the end of the block.

    Raises:
        LinkError: It cannot be reached, or the connection was lost.
        RefusedError: It refuses homebot; the message gives the remedy.
        WireError: The peer that answers is not an ESPHome device.
    """
    client = GatedClient(
        addresses[0],
        port,
        None if password is None else password.get_secret_value(),
        client_info="homebot",
        keepalive=PING_EVERY,
        noise_psk=None if key is None else key.get_secret_value(),
        addresses=list(addresses),
        provide_time=False,
    )
    connection = EsphomeConnection(name, client)

    async def open_at(address: str) -> MeteredSocket:
        with _translated(name):
            return await open_socket(address, port)

    opened = await first_answer(name, addresses, open_at)
    try:
        with _translated(name):
            client.start_connection_from_socket(opened, connection.on_stop, log_errors=False)
            opened.limit_buffer()  # which the library has made 2 MiB
            await client.finish_connection(login=password is not None)
        yield connection
    except LinkError:
        if not opened.is_flooded:
            raise
    finally:
        await client.disconnect(force=True)
    if opened.is_flooded:
        raise WireError(f"{name} sends more than {PER_SECOND:,} bytes each second")


def _with_compatible(info: model.EntityInfo, version: model.APIVersion) -> Fields:
    """Return the fields of an entity, with the deprecated fields of old firmware translated to current ones."""
    fields: dict[str, object] = info.to_dict()
    if isinstance(info, model.LightInfo):
        fields["supported_color_modes"] = info.supported_color_modes_compat(version)
    elif isinstance(info, model.ClimateInfo):
        fields["feature_flags"] = info.supported_feature_flags_compat(version)
        fields["supported_presets"] = info.supported_presets_compat(version)
    elif isinstance(info, model.MediaPlayerInfo):
        fields["feature_flags"] = info.feature_flags_compat(version)
    return fields


@contextmanager
def _translated(name: str) -> Iterator[None]:
    """Turn the library's errors into ours; no error shows a secret."""
    try:
        yield
    except (core.InvalidEncryptionKeyAPIError, core.RequiresEncryptionAPIError) as exc:
        wants = "another encryption key" if isinstance(exc, core.HandshakeAPIError) else "encryption"
        raise RefusedError(f"the connection to {name}", f"it wants {wants}; {KEY_ADVICE.format(name)}") from None
    except (core.EncryptionPlaintextAPIError, core.EncryptionHelloAPIError):
        raise RefusedError(f"the connection to {name}", f"it does not encrypt; {PLAIN_ADVICE.format(name)}") from None
    except core.InvalidAuthAPIError:
        raise RefusedError(
            f"the connection to {name}", f"it wants another password; {PASSWORD_ADVICE.format(name)}"
        ) from None
    except (core.HandshakeAPIError, core.ProtocolAPIError) as exc:
        raise WireError(f"{name} does not follow ESPHome's native API: {clean_text(str(exc))}") from None
    except (core.APIConnectionError, OSError, TimeoutError) as exc:
        raise LinkError(f"{name} cannot be reached: {clean_text(str(exc)) or type(exc).__name__}") from None


class MeteredSocket(socket.socket):
    """A TCP socket that fails when the peer sends more than :data:`PER_SECOND`."""

    def __init__(self, family: int, kind: int, protocol: int) -> None:
        super().__init__(family, kind, protocol)
        self.is_flooded = False
        self._limit = RateLimit(PER_SECOND, BURST)

    def limit_buffer(self) -> None:
        """Keep the receive buffer of the kernel small."""
        self.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVED_AT_ONCE)

    def recv(self, bufsize: int, flags: int = 0, /) -> bytes:
        """Return received data."""
        data = super().recv(bufsize, flags)
        if self._limit.charge(asyncio.get_running_loop().time(), len(data)) > 0:
            self.is_flooded = True
            raise ConnectionAbortedError("the device sends too much data")
        return data


async def open_socket(address: str, port: int) -> MeteredSocket:
    """Return a socket that is connected to *address*."""
    (family, kind, protocol, _, place), *_ = socket.getaddrinfo(
        address, port, type=socket.SOCK_STREAM, flags=socket.AI_NUMERICHOST
    )
    made = MeteredSocket(family, kind, protocol)
    try:
        made.setblocking(False)  # noqa: FBT003 - the standard library wants it so
        made.limit_buffer()
        with anyio.fail_after(CONNECT_WITHIN):
            await asyncio.get_running_loop().sock_connect(made, place)
    except BaseException:
        made.close()
        raise
    return made
