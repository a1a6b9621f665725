"""The certificates of tests, judged by OpenSSL as Python has it."""

from __future__ import annotations

import ssl
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from homebot.testing.mqtt import TestTls
from homebot.testing.mqtt.certificates import ServerCertificate
from homebot.testing.mqtt.p256 import SigningKey

NOW = datetime.now(UTC)


def shake_hands(tls: TestTls, name: str, trusted: Path) -> object:
    """Join both sides in memory; returns the name that the client saw in the certificate."""
    client_context = ssl.create_default_context(cafile=trusted)
    client_context.verify_flags |= ssl.VERIFY_X509_STRICT
    up, down = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = client_context.wrap_bio(down, up, server_hostname=name)
    server = tls.context.wrap_bio(up, down, server_side=True)
    waiting = [client, server]
    for _ in range(10):
        for side in list(waiting):
            try:
                side.do_handshake()
            except ssl.SSLWantReadError:
                continue
            waiting.remove(side)
    assert not waiting
    return (client.getpeercert() or {})["subject"]


@pytest.mark.parametrize("name", ["127.0.0.1", "::1", "localhost"])
def test_a_strict_client_that_trusts_the_authority_accepts_it(tmp_path: Path, name: str) -> None:
    tls = TestTls.make(tmp_path, NOW)
    assert shake_hands(tls, name, tls.ca_file) == ((("commonName", "localhost"),),)


def test_other_names_and_other_authorities_are_refused(tmp_path: Path) -> None:
    other_folder = tmp_path / "other"
    other_folder.mkdir()
    tls, other = TestTls.make(tmp_path, NOW), TestTls.make(other_folder, NOW)
    with pytest.raises(ssl.SSLCertVerificationError, match="IP address mismatch"):
        shake_hands(tls, "127.0.0.2", tls.ca_file)
    with pytest.raises(ssl.SSLCertVerificationError):
        shake_hands(tls, "localhost", other.ca_file)


def test_it_ends_after_a_month(tmp_path: Path) -> None:
    tls = TestTls.make(tmp_path, NOW - timedelta(days=31))
    with pytest.raises(ssl.SSLCertVerificationError, match="expired"):
        shake_hands(tls, "localhost", tls.ca_file)


def test_the_key_is_for_its_owner_alone_and_never_shown(tmp_path: Path) -> None:
    TestTls.make(tmp_path, NOW)
    assert (tmp_path / "server.pem").stat().st_mode & 0o077 == 0
    assert "PRIVATE" not in repr(ServerCertificate.make(NOW))


def test_the_public_key_is_that_of_the_standard() -> None:
    # SEC 2, section 2.4.2: the base point; and twice the base point.
    assert SigningKey(1).public.hex() == (
        "04"
        "6b17d1f2e12c4247f8bce6e563a440f277037d812deb33a0f4a13945d898c296"
        "4fe342e2fe1a7f9b8ee7eb4a7c0f9e162bce33576b315ececbb6406837bf51f5"
    )
    assert SigningKey(2).public.hex() == (
        "04"
        "7cf27b188d034f7e8a52380304b51ac3c08969e277f21b35a60b48fc47669978"
        "07775510db8ed040293d9ac69f7430dbba7dade63ce982299e04b79d227873d1"
    )
