"""The words for what went wrong on a socket."""

from __future__ import annotations

import errno
import ssl

import pytest

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client.tcp_transport import socket_error


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (
            ConnectionRefusedError(errno.ECONNREFUSED, "Connect call failed ('127.0.0.1', 19511)"),
            "nothing is listening there (connection refused): start it, or correct the address",
        ),
        (ConnectionResetError(errno.ECONNRESET, "Connection reset by peer"), "the broker reset the connection"),
        (
            ssl.SSLEOFError(8, "EOF occurred in violation of protocol (_ssl.c:2427)"),
            "the broker closed the connection",
        ),
    ],
)
def test_the_link_is_to_blame_in_plain_words(error: OSError, words: str) -> None:
    found = socket_error(error)
    assert isinstance(found, LinkError)
    assert str(found) == words


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        ("TLSV13_ALERT_CERTIFICATE_REQUIRED", "client certificate required; set cert_file and key_file"),
        ("WRONG_VERSION_NUMBER", "the server there does not use TLS; is it the port for mqtt://?"),
        (
            "SSLV3_ALERT_HANDSHAKE_FAILURE",
            "handshake failure; does the broker require a client certificate (cert_file)?",
        ),
        ("TLSV1_ALERT_PROTOCOL_VERSION", "tlsv1 alert protocol version"),
    ],
)
def test_a_no_of_tls_is_a_no_with_a_hint(reason: str, words: str) -> None:
    error = ssl.SSLError(1, f"[SSL: {reason}] (_ssl.c:1006)")
    error.reason = reason
    found = socket_error(error)
    assert isinstance(found, RefusedError)
    assert found.reason == words
