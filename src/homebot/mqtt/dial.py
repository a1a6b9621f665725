"""Open a TCP or TLS connection without blocking the loop, and leave nothing behind when that is cancelled."""

from __future__ import annotations

import asyncio
import socket
import ssl
from pathlib import Path

import anyio
import anyio.to_thread

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt.options import MqttOptions

__all__ = ["dial", "make_tls_context", "socket_error"]


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
        raise LinkError(f"{options.url}: no answer within {options.timeout:g} s") from error
    except ssl.SSLCertVerificationError as error:
        raise RefusedError(f"the certificate of {options.url}", error.verify_message) from error
    except OSError as error:
        raise socket_error(options.url, error) from error


def socket_error(url: str, error: OSError) -> LinkError | RefusedError:
    """What a failure of a socket means: a no of the TLS hand-shake is a no, all else is the link."""
    if isinstance(error, ssl.SSLError) and not isinstance(error, ssl.SSLEOFError | ssl.SSLZeroReturnError):
        return RefusedError(f"TLS with {url}", (error.reason or "hand-shake failed").lower().replace("_", " "))
    return LinkError(f"{url}: {error.strerror or error}")


async def make_tls_context(options: MqttOptions) -> ssl.SSLContext:
    """Read the certificate files.

    Raises:
        UsageError: A file cannot be read or does not hold what it should; names the file.
    """
    return await anyio.to_thread.run_sync(_load_context, options)


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
    except BaseException:
        sock.close()
        raise


def _load_context(options: MqttOptions) -> ssl.SSLContext:
    try:
        context = ssl.create_default_context(cafile=options.ca_file)
    except (OSError, ssl.SSLError) as error:
        raise UsageError(f"MQTT options: CA file {options.ca_file}: {_say(error)}") from error
    if options.cert_file is not None:
        _load_client_certificate(context, options.cert_file, options.key_file)
    return context


def _load_client_certificate(context: ssl.SSLContext, cert_file: Path, key_file: Path | None) -> None:
    try:
        context.load_cert_chain(cert_file, key_file)
    except (OSError, ssl.SSLError) as error:
        raise UsageError(
            f"MQTT options: client certificate {cert_file} with key {key_file or cert_file}: {_say(error)}"
        ) from error


def _say(error: OSError) -> str:
    return (error.reason or "not usable") if isinstance(error, ssl.SSLError) else (error.strerror or str(error))
