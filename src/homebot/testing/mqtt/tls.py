"""TLS for the brokers of tests: the files, and the server's side made from them."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Self

from homebot.mqtt.certificate import load_certificate
from homebot.testing.mqtt.certificates import ServerCertificate

__all__ = ["TestTls"]


@dataclass(frozen=True, slots=True)
class TestTls:
    """A certificate for 127.0.0.1, ::1 and localhost.

    Attributes:
        ca_file: PEM file of the authority that clients are to trust.
        context: The server's side.
    """

    __test__ = False  # no collection of tests, whatever the name

    ca_file: Path
    context: ssl.SSLContext

    @classmethod
    def make(cls, folder: Path, now: datetime) -> Self:
        """Make new keys, and write what clients and server need into *folder*."""
        made = ServerCertificate.make(now)
        ca_file, own_file = folder / "ca.pem", folder / "server.pem"
        ca_file.write_text(made.authority, encoding="ascii")
        own_file.touch(mode=0o600)
        own_file.write_text(made.certificate + made.key, encoding="ascii")
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        load_certificate(context, own_file, None, what="test certificate", key_option="key_file")
        return cls(ca_file, context)
