"""A HomeKit lamp over Thread, on loopback: aiocoap carries, HAP-python pairs, and aiohomekit encodes its description.

Nobody else publishes an accessory that speaks HomeKit over CoAP, so this one is as aiohomekit expects it.
"""

import hashlib
import socket
import struct
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import h11
from aiocoap import Context, Message, resource
from aiocoap.numbers.codes import Code
from aiohomekit.controller.coap import structs as coap_structs
from aiohomekit.controller.coap.pdu import OpCode
from aiohomekit.protocol.tlv import HAP_TLV, TLV
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from pyhap.hap_crypto import hap_hkdf
from pyhap.hap_handler import HAPServerHandler
from pyhap.hsrp import Server as SrpServer
from pyhap.params import get_srp_context
from pyhap.state import State

from homebot.integrations.homekit.gateway.port import FoundAccessory

structs: Any = coap_structs
"""Its constructors want types of its own, which are whole numbers."""

PIN = "031-45-154"
ID = "12:34:56:78:9A:BC"
ON, BRIGHTNESS, PAIRINGS, SLEEP = 9, 10, 3, 21
_FORMATS = {"bool": 0x01, "int": 0x08, "string": 0x19}
_READ, _WRITE, _EVENTS = 0x10, 0x20, 0x80
_REFUSED = 6


class ThreadLamp:
    """The lamp.

    Attributes:
        written: What was written, in order.
        refuses: Whether it refuses all writes.
        sleep: Milliseconds between two wake-ups.
        pairing_locked_out: False, as it takes any number of wrong codes; HAP-python asks since 5.2.
        answers: Set while it answers.
    """

    def __init__(self) -> None:
        self.state = State(address="::1", mac=ID, pincode=PIN.encode(), port=1)
        self.written: list[tuple[int, bytes]] = []
        self.refuses = False
        self.sleep = 0
        self.pairing_locked_out = False
        self.answers = anyio.Event()
        self.answers.set()
        self.values = {ON: b"\0", BRIGHTNESS: struct.pack("<L", 50)}
        self.srp_verifier: Any = None
        self.session: _Session | None = None
        self._context: Any = None
        with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as probe:
            probe.bind(("::1", 0))
            self.port = probe.getsockname()[1]

    def setup_srp_verifier(self) -> None:
        self.srp_verifier = SrpServer(get_srp_context(3072, hashlib.sha512, 16), b"Pair-Setup", self.state.pincode)

    def pair(self, username: bytes, key: bytes, permissions: bytes) -> bool:
        self.state.add_paired_client(username, key, permissions)
        return True

    def register_failed_pairing_attempt(self) -> None:
        """Count none."""

    @property
    def found(self) -> FoundAccessory:
        """The lamp, as it is announced."""
        return FoundAccessory(ID, "Hall", "::1", self.port, "_hap._udp", is_paired=self.state.paired)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Be reachable inside the block, with a session of none."""
        self.session = None
        site = resource.Site()
        handler = HAPServerHandler(self, "controller")
        site.add_resource(["1"], _Exchange(self, handler, "/pair-setup"))
        site.add_resource(["2"], _Exchange(self, handler, "/pair-verify"))
        site.add_resource([], _Pdus(self))
        self._context = await Context.create_server_context(site, bind=("::1", self.port))
        try:
            yield
        finally:
            await self._context.shutdown()

    async def report(self, iid: int, value: bytes) -> None:
        """Change a value, and send the event."""
        self.values[iid] = value
        assert self.session is not None
        body = bytes(TLV.encode_list([(HAP_TLV.kTLVHAPParamValue, value)]))
        request = Message(code=Code.PUT, payload=self.session.seal_event(struct.pack("<BHH", 0, iid, len(body)) + body))
        request.remote = self.session.remote
        await self._context.request(request).response

    def answer(self, request: bytes) -> bytes:
        """Answer all PDUs of a request."""
        return b"".join(
            struct.pack("<BBBH", 2, tid, status, len(body)) + body for tid, status, body in self._carry_out(request)
        )

    def _carry_out(self, request: bytes) -> Iterator[tuple[int, int, bytes]]:
        while request:
            _, code, tid, iid, length = struct.unpack("<BBBHH", request[:7])
            data, request = request[7 : 7 + length], request[7 + length :]
            status, body = 0, b""
            if code == OpCode.UNK_09_READ_GATT.value:
                body = _database()
            elif code == OpCode.CHAR_READ.value:
                value = {SLEEP: struct.pack("<L", self.sleep), **self.values}.get(iid, b"Hall")
                body = bytes(TLV.encode_list([(HAP_TLV.kTLVHAPParamValue, value)]))
            elif code == OpCode.CHAR_WRITE.value and iid == PAIRINGS:
                self.state.paired_clients.clear()
            elif code == OpCode.CHAR_WRITE.value and self.refuses:
                status = _REFUSED
            elif code == OpCode.CHAR_WRITE.value:
                value = bytes(dict(TLV.decode_bytes(data))[HAP_TLV.kTLVHAPParamValue])
                self.written.append((iid, value))
            yield tid, status, body


class _Session:
    """The keys of a session, and where its controller is."""

    def __init__(self, shared_key: bytes, remote: Any) -> None:
        self.remote = remote
        self._keys = [
            ChaCha20Poly1305(hap_hkdf(shared_key, salt, info))
            for salt, info in (
                (b"Control-Salt", b"Control-Write-Encryption-Key"),
                (b"Control-Salt", b"Control-Read-Encryption-Key"),
                (b"Event-Salt", b"Event-Read-Encryption-Key"),
            )
        ]
        self._counts = [0, 0, 0]

    def open(self, payload: bytes) -> bytes:
        return self._keys[0].decrypt(self._nonce(0), payload, b"")

    def seal(self, payload: bytes) -> bytes:
        return self._keys[1].encrypt(self._nonce(1), payload, b"")

    def seal_event(self, payload: bytes) -> bytes:
        return self._keys[2].encrypt(self._nonce(2), payload, b"")

    def _nonce(self, index: int) -> bytes:
        self._counts[index] += 1
        return struct.pack("=4xQ", self._counts[index] - 1)


class _Exchange(resource.Resource):  # type: ignore[misc]
    """One of the two pairing procedures, by HAP-python."""

    def __init__(self, lamp: ThreadLamp, handler: HAPServerHandler, path: str) -> None:
        super().__init__()
        self._lamp, self._handler, self._path = lamp, handler, path

    async def render_post(self, request: Message) -> Message:
        posted = h11.Request(method="POST", target=self._path, headers=[("host", "lamp")])
        answer = self._handler.dispatch(posted, bytes(request.payload))
        if answer.shared_key:
            self._lamp.session = _Session(answer.shared_key, request.remote)
        return Message(code=Code.CHANGED, payload=bytes(answer.body))


class _Pdus(resource.Resource):  # type: ignore[misc]
    """What a session asks."""

    def __init__(self, lamp: ThreadLamp) -> None:
        super().__init__()
        self._lamp = lamp

    async def render_post(self, request: Message) -> Message:
        await self._lamp.answers.wait()
        session = self._lamp.session
        if session is None or request.remote != session.remote:
            return Message(code=Code.NOT_FOUND)
        return Message(code=Code.CHANGED, payload=session.seal(self._lamp.answer(session.open(request.payload))))


def _database() -> bytes:
    services = (
        _service(1, 0x3E, _characteristic(2, 0x23, "string", _READ)),
        _service(22, 0x55, _characteristic(PAIRINGS, 0x50, "", _READ | _WRITE)),
        _service(
            8,
            0x43,
            _characteristic(ON, 0x25, "bool", _READ | _WRITE | _EVENTS),
            _characteristic(BRIGHTNESS, 0x8, "int", _READ | _WRITE | _EVENTS, valid_range=struct.pack("<LL", 0, 100)),
        ),
        _service(20, 0x239, _characteristic(SLEEP, 0x23A, "int", _READ)),
    )
    accessory = structs.Pdu09Accessory(
        instance_id=1, _services=[structs.Pdu09ServiceContainer(one) for one in services]
    )
    database = structs.Pdu09Database(_accessories=[structs.Pdu09AccessoryContainer(accessory)])
    return bytes(database.encode())


def _service(iid: int, kind: int, *characteristics: Any) -> Any:
    listed = [structs.Pdu09CharacteristicContainer(one) for one in characteristics]
    return structs.Pdu09Service(type=kind, instance_id=iid, _characteristics=listed)


def _characteristic(iid: int, kind: int, shape: str, perms: int, **more: Any) -> Any:
    presentation = struct.pack("<BxHxxx", _FORMATS[shape], 0x2700) if shape else None
    return structs.Pdu09Characteristic(
        type=kind, instance_id=iid, properties=perms, presentation_format=presentation, **more
    )
