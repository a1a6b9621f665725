"""Links over TCP and TLS, and the meaning of their failures.

Everything runs in the loop's thread. Incoming bytes are read from the socket as fast as possible, at most 16 MiB ahead,
and parsed in portions, so that a burst blocks neither the broker nor the loop.
"""

from __future__ import annotations

import asyncio
import errno
import socket
import ssl
from collections import deque
from typing import Final, cast, final

import anyio
import anyio.to_thread

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt.client.transport import SEND_BUFFER, TransportUser
from homebot.mqtt.options import MqttOptions
from homebot.support.addresses import ip_version

_PORTION: Final = 32 * 1024
"""Bytes parsed in one turn of the loop: a few hundred messages, a few milliseconds of work."""

_BUFFER: Final = 256 * 1024
"""Most bytes read from the socket at once; smaller reads are too slow for a flood from the broker."""

_READ_AHEAD: Final = 16 * 1024 * 1024
"""Most bytes waiting to be parsed; see `ReadAhead` for the reason."""

_SINGLE_ACKNOWLEDGEMENT: Final = 4  # bytes of a PUBACK or PUBREC
_HOLD: Final = 0.001  # seconds for which a single one, or one of TCP in a burst, waits for others
_GOODBYE: Final = 1.0
"""Seconds that a clean close may take; the broker may be gone already."""

_TCP_QUICKACK: Final[int | None] = getattr(socket, "TCP_QUICKACK", None)  # Linux has it


async def dial_tcp(options: MqttOptions, user: TransportUser) -> TcpTransport:
    """Connect to the broker's port; with TLS, shake hands and verify its certificate.

    A cancellation leaves nothing behind. Small packets are sent at once: Nagle's algorithm costs up to 44 ms for each
    acknowledged publish on some brokers.

    Raises:
        LinkError: No address of the host answers within the time limit.
        RefusedError: The broker's certificate is not trusted, or the broker rejects ours.
        UsageError: A certificate file cannot be used.
    """
    context = await make_tls_context(options) if options.tls else None  # each time: certificates are renewed
    transport = TcpTransport(user)
    try:
        with anyio.fail_after(options.timeout):
            await transport.carry(await _connect(options), options, context)
    except TimeoutError as error:
        raise LinkError(f"no answer within {options.timeout:g} s") from error
    except OSError as error:
        raise socket_error(error) from error
    return transport


@final
class TcpTransport(asyncio.BufferedProtocol):
    """A link over TCP; a :class:`homebot.mqtt.client.transport.ClientTransport`.

    Attributes:
        socket: The connected socket; None before.
    """

    def __init__(self, user: TransportUser) -> None:
        self._loop = asyncio.get_running_loop()
        self._user = user
        self._transport: asyncio.Transport | None = None
        self.socket: socket.socket | None = None
        self._buffer = memoryview(bytearray(_BUFFER))
        self._ahead = ReadAhead(_PORTION, _READ_AHEAD)
        self._is_reading = True
        self._held = b""
        self._release: asyncio.TimerHandle | None = None
        self._acknowledgement: asyncio.TimerHandle | None = None  # of TCP, which is due
        self._acknowledged_at = 0.0
        self._closed = anyio.Event()

    async def carry(self, sock: socket.socket, options: MqttOptions, context: ssl.SSLContext | None) -> None:
        """Take over the connected socket *sock*, closed on failure; with *context*, shake hands first.

        Raises:
            LinkError: The handshake failed.
            RefusedError: One side does not trust the other's certificate.
        """
        try:
            if context is None:
                await self._loop.create_connection(lambda: self, sock=sock)
                return
            await self._loop.create_connection(
                lambda: self,
                sock=sock,
                ssl=context,
                server_hostname=options.host,
                ssl_handshake_timeout=2 * options.timeout,  # never; the caller's limit is shorter
                ssl_shutdown_timeout=_GOODBYE,
            )
        except OSError as error:
            sock.close()
            raise dial_error(error, in_tls=context is not None) from error
        except BaseException:
            sock.close()
            raise

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Set up the open connection."""
        self._transport = cast("asyncio.Transport", transport)
        self._transport.set_write_buffer_limits(high=SEND_BUFFER)
        self.socket = transport.get_extra_info("socket")
        self._acknowledge()

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002 - as asyncio calls it
        """Return the buffer for the next bytes: always the same, as asyncio would allocate 256 KiB for each read."""
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Handle bytes from the socket."""
        data = bytes(self._buffer[:nbytes])
        if self._ahead.size or len(data) > _PORTION:
            if not self._ahead.size:
                self._loop.call_soon(self._read_portion)
            self._ahead.put(data)
            if self._ahead.is_full and self._transport is not None:
                self._transport.pause_reading()
                self._is_reading = False
        else:
            self._user.data_received(data)
        self._acknowledge()

    def pause_writing(self) -> None:
        """Do nothing: the user checks `waiting`."""

    def resume_writing(self) -> None:
        """Resume after the broker has read most of the data."""
        self._user.drained()

    def connection_lost(self, exc: Exception | None) -> None:
        """Clean up after the closed connection."""
        while portion := self._ahead.pop():  # data before the end counts
            self._user.data_received(portion)
        self._drop_held()
        if self._acknowledgement is not None:
            self._acknowledgement.cancel()
        self._closed.set()
        lost = socket_error(exc) if isinstance(exc, OSError) else LinkError("the broker closed the connection")
        self._user.link_ended(lost)

    @property
    def waiting(self) -> int:
        """Written bytes that the broker has not read yet."""
        return 0 if self._transport is None else self._transport.get_write_buffer_size()

    def write(self, data: bytes) -> None:
        """Send *data* at once if the socket accepts it, otherwise in turn."""
        if self._held:
            data = self._held + data
            self._drop_held()
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(data)

    def write_acknowledgements(self, data: bytes) -> None:
        """Send many at once; a single one a moment later, together with the answer that it may cause."""
        if len(data) > _SINGLE_ACKNOWLEDGEMENT:
            self.write(data)
            return
        self._held += data
        if self._release is None:
            self._release = self._loop.call_later(_HOLD, self.write, b"")

    def close(self) -> None:
        """Close after sending all written data."""
        self.write(b"")
        if self._transport is not None:
            self._transport.close()

    async def wait_closed(self) -> None:
        """Wait for the end of the close; after a second the link is cut."""
        if self._transport is None:
            return
        with anyio.CancelScope(shield=True):
            with anyio.move_on_after(_GOODBYE):
                await self._closed.wait()
            self.abort()
            await self._closed.wait()

    def abort(self) -> None:
        """Cut the link."""
        self._ahead = ReadAhead(_PORTION, _READ_AHEAD)
        self._drop_held()
        if self._transport is not None and not self._closed.is_set():
            self._transport.abort()

    def _drop_held(self) -> None:
        self._held = b""
        if self._release is not None:
            self._release.cancel()
            self._release = None

    def _read_portion(self) -> None:
        if portion := self._ahead.pop():
            self._user.data_received(portion)
        if self._ahead.size:
            self._loop.call_soon(self._read_portion)
        if not self._is_reading and not self._ahead.is_full and self._transport is not None:
            self._is_reading = True
            self._transport.resume_reading()

    def _acknowledge(self) -> None:
        # Make TCP acknowledge incoming bytes without delay: a broker with Nagle's algorithm, such as Mosquitto,
        # waits up to 40 ms for it. Linux resets the option after a while, so it is set again; in a burst once in a
        # millisecond, as otherwise messages arrive one by one, at two thirds of the speed.
        if _TCP_QUICKACK is None or self._acknowledgement is not None:
            return
        wait = self._acknowledged_at + _HOLD - self._loop.time()
        if wait > 0:
            self._acknowledgement = self._loop.call_later(wait, self._acknowledge_now, _TCP_QUICKACK)
        else:
            self._acknowledge_now(_TCP_QUICKACK)

    def _acknowledge_now(self, option: int) -> None:
        self._acknowledgement = None
        self._acknowledged_at = self._loop.time()
        if self.socket is not None and self.socket.fileno() >= 0:
            self.socket.setsockopt(socket.IPPROTO_TCP, option, 1)


@final
class ReadAhead:
    """Bytes that have been read but not parsed yet, in order.

    A broker sends all retained messages at once, and some drop those that the socket does not accept in time. So
    bytes are read from the socket as fast as possible, and parsed in portions. Its owner bounds it: see `is_full`.

    Args:
        portion: Most bytes returned at once.
        most: Bytes that make it full.

    Attributes:
        size: Bytes waiting.
    """

    def __init__(self, portion: int, most: int) -> None:
        self._portion = portion
        self._most = most
        self._chunks: deque[memoryview] = deque()
        self.size = 0

    @property
    def is_full(self) -> bool:
        """True if nothing more should be read for now."""
        return self.size >= self._most

    def put(self, data: bytes) -> None:
        """Append *data*."""
        self._chunks.append(memoryview(data))
        self.size += len(data)

    def pop(self) -> bytes:
        """Remove and return the next portion; empty if there is none."""
        if not self._chunks:
            return b""
        chunk = self._chunks.popleft()
        portion = bytes(chunk[: self._portion])
        if len(chunk) > self._portion:
            self._chunks.appendleft(chunk[self._portion :])
        self.size -= len(portion)
        return portion


async def make_tls_context(options: MqttOptions) -> ssl.SSLContext:
    """Read the certificate files.

    Raises:
        UsageError: A file cannot be read or is invalid; the message names it.
    """
    return await anyio.to_thread.run_sync(_load_context, options)


def socket_error(error: OSError) -> LinkError | RefusedError:
    """Interpret a failure of a socket: RefusedError for a refused TLS handshake, LinkError for everything else.

    The texts do not name the broker: the caller does.
    """
    if isinstance(error, ssl.SSLCertVerificationError):
        return RefusedError("the broker's certificate", error.verify_message)
    if isinstance(error, ssl.SSLEOFError | ssl.SSLZeroReturnError):
        return LinkError("the broker closed the connection")
    if isinstance(error, ssl.SSLError):
        reason = error.reason or "handshake failed"
        plain = reason.lower().replace("_", " ")
        return RefusedError("TLS", next((words for part, words in _TLS_PROBLEMS if part in reason), plain))
    from homebot.support.connect_errors import connect_problem  # noqa: PLC0415 - most connections last

    return LinkError(_LOST.get(error.errno or 0) or connect_problem(error))


def dial_error(error: OSError, *, in_tls: bool) -> LinkError | RefusedError:
    """Interpret a failure to connect; *in_tls* if it may have occurred during the TLS handshake."""
    if in_tls and isinstance(error, _CUT):
        return LinkError(
            "the broker closed the connection during the TLS handshake; is this its port for TLS, "
            "and does the broker require a client certificate (cert_file)?"
        )
    return socket_error(error)


async def _connect(options: MqttOptions) -> socket.socket:
    loop = asyncio.get_running_loop()
    failure: OSError = OSError("the host name has no address")
    for family, address in await _resolve(options):
        sock = socket.socket(family, socket.SOCK_STREAM)
        try:
            sock.setblocking(False)  # noqa: FBT003 - the standard library's own
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            await loop.sock_connect(sock, address)
        except OSError as error:
            sock.close()
            failure = error
        except BaseException:
            sock.close()
            raise
        else:
            return sock
    raise failure


async def _resolve(options: MqttOptions) -> list[tuple[int, tuple[object, ...]]]:
    """Return the broker's addresses with their families; a literal address needs no lookup in a thread."""
    version = ip_version(options.host)
    if version is not None:
        return [(socket.AF_INET if version == 4 else socket.AF_INET6, (options.host, options.port))]
    loop = asyncio.get_running_loop()
    infos = await loop.getaddrinfo(options.host, options.port, type=socket.SOCK_STREAM)
    return [(family, address) for family, _, _, _, address in infos]


def _load_context(options: MqttOptions) -> ssl.SSLContext:
    try:
        context = ssl.create_default_context(cafile=options.ca_file)
    except ssl.SSLError as error:
        raise UsageError(f"CA file {options.ca_file}: no certificate was found in it") from error
    except OSError as error:
        raise UsageError(f"CA file {options.ca_file}: {error.strerror}") from error
    if options.cert_file is not None:
        from homebot.mqtt.certificate import load_certificate  # noqa: PLC0415 - few clients have one

        load_certificate(context, options.cert_file, options.key_file, what="client certificate", key_option="key_file")
    return context


_CUT: Final = (ssl.SSLEOFError, ssl.SSLZeroReturnError, ConnectionResetError, BrokenPipeError)
_LOST: Final = {
    errno.ECONNRESET: "the broker reset the connection",
    errno.EPIPE: "the broker closed the connection",
}

_NO_TLS: Final = "the server there does not use TLS; is it the port for mqtt://?"
_TLS_PROBLEMS: Final = (
    ("CERTIFICATE_REQUIRED", "client certificate required; set cert_file and key_file"),
    ("HANDSHAKE_FAILURE", "handshake failure; does the broker require a client certificate (cert_file)?"),
    ("UNKNOWN_CA", "the broker does not trust the issuer of the client certificate (cert_file)"),
    ("WRONG_VERSION_NUMBER", _NO_TLS),
    ("RECORD_LAYER_FAILURE", _NO_TLS),  # the same since OpenSSL 3.2
)
