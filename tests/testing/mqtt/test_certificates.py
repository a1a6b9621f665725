"""The certificates of tests, judged by OpenSSL as Python has it."""

import ssl
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from homebot.testing.mqtt import TestTls

NOW = datetime.now(UTC)


def shake_hands(tls: TestTls, name: str, trusted: Path) -> tuple[object, ...]:
    """Join both sides in memory; returns the subject that the client saw in the certificate."""
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
    certificate = client.getpeercert()
    assert certificate is not None
    return tuple(certificate["subject"])


@pytest.mark.parametrize("name", ["127.0.0.1", "::1", "localhost"])
def test_a_strict_client_that_trusts_the_authority_accepts_it(tmp_path: Path, name: str) -> None:
    tls = TestTls.make(tmp_path, NOW)
    assert (("commonName", "localhost"),) in shake_hands(tls, name, tls.ca_file)


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
    tls = TestTls.make(tmp_path, NOW)
    assert (tmp_path / "server.pem").stat().st_mode & 0o077 == 0
    assert "PRIVATE" not in tls.ca_file.read_text() + repr(tls)


def test_without_trustme_it_is_told_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trustme", None)
    with pytest.raises(ImportError, match=r"with TLS needs trustme: pip install 'homebot\[testing\]'"):
        TestTls.make(tmp_path, NOW)
