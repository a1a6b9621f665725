"""Open a TCP or TLS connection without blocking the loop, and leave nothing behind when that is cancelled."""

from __future__ import annotations

import asyncio
import socket
import ssl
from typing import Final

import anyio

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client.tcp_transport import socket_error
from homebot.mqtt.options import MqttOptions

__all__ = ["dial"]

_CUT: Final = (ssl.SSLEOFError, ssl.SSLZeroReturnError, ConnectionResetError, BrokenPipeError)


async def dial(options: MqttOptions, context: ssl.SSLContext | None) -> socket.socket:
    """Connect to the broker's port; with *context*, shake hands and verify its certificate.

    Returns:
        A connected, non-blocking socket with TCP_NODELAY set (aiomqtt leaves Nagle's algorithm on, which costs
        up to 44 ms per acknowledged publish on some brokers). The caller closes it.

    Raises:
        LinkError: Nobody answers at any address of the host within the time limit.
        RefusedError: The broker's certificate is not trusted, or the broker rejects ours.
    """
    try:
        with anyio.fail_after(options.timeout):
            sock = await _connect(options)
            return sock if context is None else await _encrypt(sock, options, context)
    except TimeoutError as error:
        raise LinkError(f"no answer within {options.timeout:g} s") from error
    except ssl.SSLCertVerificationError as error:
        raise RefusedError("the broker's certificate", error.verify_message) from error
    except OSError as error:
        raise socket_error(error) from error


async def _connect(options: MqttOptions) -> socket.socket:
    loop = asyncio.get_running_loop()
    addresses = await loop.getaddrinfo(options.host, options.port, type=socket.SOCK_STREAM)
    failure: OSError = OSError("the name has no address")
    for family, kind, protocol, _, address in addresses:
        sock = socket.socket(family, kind, protocol)
        try:
            sock.settimeout(0)
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


async def _encrypt(raw: socket.socket, options: MqttOptions, context: ssl.SSLContext) -> ssl.SSLSocket:
    try:
        sock = context.wrap_socket(raw, server_hostname=options.host, do_handshake_on_connect=False)
    except BaseException:
        raw.close()
        raise
    try:
        while True:
            try:
                sock.do_handshake()
            except ssl.SSLWantReadError:
                await anyio.wait_readable(sock)
            except ssl.SSLWantWriteError:
                await anyio.wait_writable(sock)
            else:
                return sock
    except _CUT as error:
        sock.close()
        raise LinkError(
            "the broker closed the connection during the TLS hand-shake; is this its port for TLS, "
            "and does it want a client certificate (cert_file)?"
        ) from error
    except BaseException:
        sock.close()
        raise
