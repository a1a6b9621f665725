"""TLS for the brokers of tests: the files, and the server's side made from them."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Final, Self

from homebot.mqtt.certificate import load_certificate

__all__ = ["TestTls"]

_VALID: Final = timedelta(days=30)  # a test run, however long, on a computer with a wrong clock


@dataclass(frozen=True, slots=True)
class TestTls:
    """A certificate for 127.0.0.1, ::1 and localhost."""

    __test__ = False  # not a test class in spite of its name

    ca_file: Path
    context: ssl.SSLContext

    @classmethod
    def make(cls, folder: Path, now: datetime) -> Self:
        """Create new keys and write the files of clients and server into *folder*.

        Args:
            now: In UTC; the certificate is valid from a day before to thirty days after.

        Raises:
            ImportError: The package trustme is not installed.
        """
        try:
            import trustme  # noqa: PLC0415 - loads 60 modules that only tests with TLS need
        except ModuleNotFoundError as exc:
            if exc.name != "trustme":
                raise
            raise ImportError("a test broker with TLS needs trustme: pip install 'homebot[testing]'") from exc
        authority = trustme.CA(organization_name="homebot tests")
        server = authority.issue_cert(
            "localhost",
            "127.0.0.1",
            "::1",
            common_name="localhost",
            not_before=now - timedelta(days=1),
            not_after=now + _VALID,
        )
        ca_file, server_file = folder / "ca.pem", folder / "server.pem"
        authority.cert_pem.write_to_path(ca_file)
        server_file.touch(mode=0o600)
        server.private_key_and_cert_chain_pem.write_to_path(server_file)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        load_certificate(context, server_file, None, what="test certificate", key_option="key_file")
        return cls(ca_file, context)
