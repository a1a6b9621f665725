"""The device's side of ESPHome's native API on one connection: frames, encryption and messages.

Source: ESPHome 2026.10, ``components/api/api_frame_helper_plaintext.cpp`` and ``api_frame_helper_noise.cpp``; Noise
Protocol Framework, revision 34 (``Noise_NNpsk0_25519_ChaChaPoly_SHA256``).
"""

import binascii
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from aioesphomeapi.core import MESSAGE_TYPE_TO_PROTO
from anyio.abc import ByteStream
from anyio.streams.buffered import BufferedByteReceiveStream
from cryptography.exceptions import InvalidTag
from noise.connection import NoiseConnection

ApiMessage: TypeAlias = tuple[str, Mapping[str, Any]]
"""Name and fields of a message; unknown ones have an empty name."""

_PLAIN, _ENCRYPTED = 0x00, 0x01
_PROLOGUE = b"NoiseAPIInit\x00\x00"
_PROTOCOL = b"Noise_NNpsk0_25519_ChaChaPoly_SHA256"
_MAX_FRAME_BYTES = 65_535
_NUMBERS: Mapping[str, int] = {proto.__name__: number for number, proto in MESSAGE_TYPE_TO_PROTO.items()}


class ClientRefusedError(Exception):
    """A client broke the rules, or has another key; it was told so."""


@dataclass(frozen=True, slots=True)
class ServerIdentity:
    """The name and address that a device sends before authentication, and its key.

    Attributes:
        mac: Its hardware address, twelve digits.
        key: Its encryption key in base64; empty for no encryption.
    """

    name: str
    mac: str
    key: str = ""


class NativeApiStream(ABC):
    """Messages over one connection."""

    def __init__(self, received: BufferedByteReceiveStream, stream: ByteStream) -> None:
        self._received = received
        self._stream = stream

    async def receive(self) -> ApiMessage:
        """Return the next message.

        Raises:
            ClientRefusedError: The bytes are no such frame.
            anyio.EndOfStream: The client went away, as do the other errors of a stream.
        """
        number, data = await self._receive_frame()
        kind = MESSAGE_TYPE_TO_PROTO.get(number)
        if kind is None:
            return "", {}
        try:
            message = kind.FromString(data)
        except Exception as exc:
            raise ClientRefusedError(f"message {number}: {exc}") from exc
        return kind.__name__, {field.name: getattr(message, field.name) for field in message.DESCRIPTOR.fields}

    async def send(self, message: ApiMessage) -> None:
        """Send a message."""
        name, fields = message
        number = _NUMBERS[name]
        kind: Any = MESSAGE_TYPE_TO_PROTO[number]
        await self._stream.send(self._frame(number, kind(**fields).SerializeToString()))

    @abstractmethod
    async def _receive_frame(self) -> tuple[int, bytes]:
        """Return number and payload of the next message."""

    @abstractmethod
    def _frame(self, number: int, data: bytes) -> bytes:
        """Return the frame of a message."""


class _PlainStream(NativeApiStream):
    """Messages in the clear: a zero, and two varints before the payload."""

    is_first = True

    async def _receive_frame(self) -> tuple[int, bytes]:
        if not self.is_first and (await self._received.receive_exactly(1))[0] != _PLAIN:
            raise ClientRefusedError("Bad indicator byte")
        self.is_first = False
        size, number = await self._varint(), await self._varint()
        if size > _MAX_FRAME_BYTES:
            raise ClientRefusedError(f"a message of {size} bytes")
        return number, await self._received.receive_exactly(size) if size else b""

    async def _varint(self) -> int:
        value = 0
        for shift in range(0, 35, 7):
            byte = (await self._received.receive_exactly(1))[0]
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
        raise ClientRefusedError("a varint without end")

    def _frame(self, number: int, data: bytes) -> bytes:
        return bytes((_PLAIN, *_varint(len(data)), *_varint(number))) + data


class _NoiseStream(NativeApiStream):
    noise: NoiseConnection

    async def shake_hands(self, identity: ServerIdentity) -> None:
        """Have the keys of the connection agreed upon; the first byte was read.

        Raises:
            ClientRefusedError: The client has another key.
        """
        await self._read_rest()
        hello = bytes((1,)) + identity.name.encode() + b"\0" + identity.mac.encode() + b"\0"
        await self._stream.send(_noise_frame(hello))
        self.noise = NoiseConnection.from_name(_PROTOCOL)
        self.noise.set_as_responder()
        self.noise.set_psks(binascii.a2b_base64(identity.key))
        self.noise.set_prologue(_PROLOGUE)
        self.noise.start_handshake()
        try:
            self.noise.read_message((await self._read_noise())[1:])
        except (InvalidTag, ValueError) as exc:
            await self._stream.send(_noise_frame(b"\x01Handshake MAC failure"))
            raise ClientRefusedError("another key") from exc
        await self._stream.send(_noise_frame(b"\0" + bytes(self.noise.write_message())))

    async def _receive_frame(self) -> tuple[int, bytes]:
        try:
            data = bytes(self.noise.decrypt(await self._read_noise()))
        except InvalidTag as exc:
            raise ClientRefusedError("a frame that is not authentic") from exc
        if len(data) < 4:
            raise ClientRefusedError("a frame that is too short")
        return int.from_bytes(data[:2], "big"), data[4:]

    def _frame(self, number: int, data: bytes) -> bytes:
        header = number.to_bytes(2, "big") + len(data).to_bytes(2, "big")
        return _noise_frame(bytes(self.noise.encrypt(header + data)))

    async def _read_noise(self) -> bytes:
        if (await self._received.receive_exactly(1))[0] != _ENCRYPTED:
            raise ClientRefusedError("Bad indicator byte")
        return await self._read_rest()

    async def _read_rest(self) -> bytes:
        size = int.from_bytes(await self._received.receive_exactly(2), "big")
        return await self._received.receive_exactly(size) if size else b""


async def accept(stream: ByteStream, identity: ServerIdentity) -> NativeApiStream:
    """Return the messages of a client that has connected.

    Raises:
        ClientRefusedError: It does not encrypt as it has to, has another key, or speaks another protocol.
    """
    received = BufferedByteReceiveStream(stream)
    first = (await received.receive_exactly(1))[0]
    if identity.key:
        if first != _ENCRYPTED:
            await stream.send(_noise_frame(b"\x01Bad indicator byte"))
            raise ClientRefusedError("no encryption")
        encrypted = _NoiseStream(received, stream)
        await encrypted.shake_hands(identity)
        return encrypted
    if first != _PLAIN:
        await stream.send(b"\0Bad indicator byte")
        raise ClientRefusedError("encryption")
    return _PlainStream(received, stream)


def _noise_frame(data: bytes) -> bytes:
    return bytes((_ENCRYPTED,)) + len(data).to_bytes(2, "big") + data


def _varint(value: int) -> list[int]:
    messages = []
    while value > 0x7F:
        messages.append(value & 0x7F | 0x80)
        value >>= 7
    return [*messages, value]
