"""TLS on one socket of the broker.

asyncio's own needs 300 KiB per accepted socket, and does not report unfinished handshakes. Here such sockets count, and
are closed, like all others that have not logged in.
"""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final, cast, final

_MAX_READ_BYTES: Final = 16 * 1024
_MAX_ENCRYPTED_BYTES: Final = 64 * 1024  # bytes, before they are passed on


@final
class TlsSocket(asyncio.BufferedProtocol):
    """The protocol of the socket, and the transport of the upper protocol.

    Args:
        on_failure: Called with the reason for a failed handshake or invalid data after it.
    """

    def __init__(
        self, context: ssl.SSLContext, user: asyncio.BufferedProtocol, on_failure: Callable[[str], None]
    ) -> None:
        self._user = user
        self._on_failure = on_failure
        self._incoming = ssl.MemoryBIO()
        self._outgoing = ssl.MemoryBIO()
        self._tls = context.wrap_bio(self._incoming, self._outgoing, server_side=True)
        self._buffer = bytearray()
        self._raw: asyncio.Transport | None = None
        self._facade: _TlsTransport | None = None
        self._is_ready = False
        self._is_paused = False
        self._is_over = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Set up the open socket."""
        self._raw = cast("asyncio.Transport", transport)
        self._facade = _TlsTransport(self, self._raw)
        self._user.connection_made(self._facade)

    def get_buffer(self, sizehint: int) -> bytearray:  # noqa: ARG002 - asyncio's signature
        """Return the buffer for the next bytes."""
        if not self._buffer:
            self._buffer = bytearray(_MAX_READ_BYTES)
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Decrypt the received bytes."""
        self._incoming.write(memoryview(self._buffer)[:nbytes])
        self._buffer = bytearray()  # a silent socket needs no buffer
        self._go_on()

    def eof_received(self) -> bool:
        """Return False to close the socket, as the peer sends nothing more."""
        return False

    def pause_writing(self) -> None:
        """Record that the socket accepts bytes more slowly than they are written."""
        self._user.pause_writing()

    def resume_writing(self) -> None:
        """Continue writing: the socket's buffer is almost empty again."""
        self._user.resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Clean up after the closed socket."""
        self._is_over = True
        self._user.connection_lost(exc)

    def write(self, data: bytes) -> None:
        """Encrypt and send *data*; ignored before the handshake."""
        if not self._is_ready or self._is_over:
            return
        view = memoryview(data)
        try:
            for start in range(0, len(view), _MAX_ENCRYPTED_BYTES):
                self._tls.write(view[start : start + _MAX_ENCRYPTED_BYTES])
                self._send()
        except ssl.SSLError as error:
            self._fail(error)

    def pause(self) -> None:
        """Stop passing on received data."""
        self._is_paused = True

    def resume(self) -> None:
        """Pass on received data again."""
        self._is_paused = False
        asyncio.get_running_loop().call_soon(self._go_on)

    def close_tls(self) -> bool:
        """Send close_notify; return False before the handshake."""
        if not self._is_ready or self._is_over:
            return False
        self._is_over = True
        with suppress(ssl.SSLError):  # its answer has not come
            self._tls.unwrap()
        self._send()
        return True

    def _go_on(self) -> None:
        try:
            if not self._is_ready and not self._is_over:
                self._tls.do_handshake()
                self._is_ready = True
            while self._is_ready and not self._is_paused and not self._is_over:
                count = self._tls.read(_MAX_READ_BYTES, self._user.get_buffer(-1))
                if not count:
                    self._end()
                    return
                self._user.buffer_updated(cast("int", count))
        except ssl.SSLWantReadError:
            pass
        except (ssl.SSLZeroReturnError, ssl.SSLEOFError):
            self._end()
            return
        except ssl.SSLError as error:
            self._fail(error)
            return
        self._send()

    def _send(self) -> None:
        if self._outgoing.pending and self._raw is not None:
            self._raw.write(self._outgoing.read())

    def _end(self) -> None:
        self.close_tls()
        if self._raw is not None:
            self._raw.close()

    def _fail(self, error: ssl.SSLError) -> None:
        if self._is_over:
            return
        self._is_over = True
        self._on_failure(error.reason or str(error))
        self._send()  # the alert with the reason
        if self._raw is not None:
            self._raw.close()


@final
class _TlsTransport(asyncio.Transport):
    def __init__(self, owner: TlsSocket, raw: asyncio.Transport) -> None:
        super().__init__()
        self._owner = owner
        self._raw = raw

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return self._raw.get_extra_info(name, default)

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        self._raw.set_write_buffer_limits(high, low)

    def get_write_buffer_size(self) -> int:
        return self._raw.get_write_buffer_size()

    def write(self, data: bytes | bytearray | memoryview[Any]) -> None:
        self._owner.write(bytes(data))

    def pause_reading(self) -> None:
        self._owner.pause()
        self._raw.pause_reading()

    def resume_reading(self) -> None:
        self._raw.resume_reading()
        self._owner.resume()

    def can_write_eof(self) -> bool:
        return False

    def close(self) -> None:
        if self._owner.close_tls():
            self._raw.close()
        else:
            self._raw.abort()

    def abort(self) -> None:
        self._raw.abort()
