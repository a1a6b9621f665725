"""The certificate files of a connection, and what can be wrong with them."""

from __future__ import annotations

import ssl
from pathlib import Path
from typing import Final

import anyio.to_thread

from homebot.errors import UsageError
from homebot.mqtt.options import MqttOptions

__all__ = ["make_tls_context"]

_NO_PASSPHRASE: Final = "-"  # noqa: S105 - no secret; given none, OpenSSL asks for one on the terminal


async def make_tls_context(options: MqttOptions) -> ssl.SSLContext:
    """Read the certificate files.

    Raises:
        UsageError: A file cannot be read or does not hold what it should; names the file.
    """
    return await anyio.to_thread.run_sync(_load_context, options)


def _load_context(options: MqttOptions) -> ssl.SSLContext:
    try:
        context = ssl.create_default_context(cafile=options.ca_file)
    except ssl.SSLError as error:
        raise UsageError(f"CA file {options.ca_file}: no certificate was found in it") from error
    except OSError as error:
        raise UsageError(f"CA file {options.ca_file}: {error.strerror}") from error
    if options.cert_file is not None:
        _load_client_certificate(context, options.cert_file, options.key_file)
    return context


def _load_client_certificate(context: ssl.SSLContext, cert_file: Path, key_file: Path | None) -> None:
    certificate = _read("client certificate", cert_file)
    key = certificate if key_file is None else _read("key of the client certificate", key_file)
    try:
        context.load_cert_chain(cert_file, key_file, password=_NO_PASSPHRASE)
    except (OSError, ssl.SSLError) as error:
        where = key_file or cert_file
        if b"-----BEGIN CERTIFICATE" not in certificate:
            problem = f"no certificate was found in {cert_file}"
        elif b"PRIVATE KEY-----" not in key:
            problem = f"no key was found in {where}{'; set key_file' if key_file is None else ''}"
        elif b"ENCRYPTED" in key:
            problem = f"the key in {where} is locked with a passphrase; homebot needs one without"
        else:
            problem = f"the key in {where} does not fit the certificate in {cert_file}, or cannot be read"
        raise UsageError(f"client certificate: {problem}") from error


def _read(what: str, path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{what} {path}: {error.strerror}") from error
