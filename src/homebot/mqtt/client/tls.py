"""The TLS of a client's connection, made from its certificate files."""

from __future__ import annotations

import ssl

import anyio.to_thread

from homebot.errors import UsageError
from homebot.mqtt.certificate import load_certificate
from homebot.mqtt.options import MqttOptions

__all__ = ["make_tls_context"]


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
        load_certificate(context, options.cert_file, options.key_file, what="client certificate", key_option="key_file")
    return context
