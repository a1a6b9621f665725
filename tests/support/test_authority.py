"""A local authority: made once, and its certificates anew where that is due."""

from pathlib import Path

import pytest
from cryptography import x509

from homebot.errors import UsageError
from homebot.support.authority import AUTHORITY, renew_certificate

NOW = 1_800_000_000.0
DAY = 86_400.0
HOSTS = ["localhost", "127.0.0.1", "villa.local"]


def serial(file: Path) -> int:
    return x509.load_pem_x509_certificate(file.read_bytes()).serial_number


def test_a_certificate_is_kept_until_its_last_month_and_the_authority_beyond(tmp_path: Path) -> None:
    certificate, key = renew_certificate(tmp_path, "door", HOSTS, NOW)
    first, authority = serial(certificate), (tmp_path / AUTHORITY).read_bytes()
    assert certificate.read_bytes().endswith(authority)
    assert {file.stat().st_mode & 0o777 for file in tmp_path.iterdir()} == {0o600}
    found = [serial(renew_certificate(tmp_path, "door", HOSTS, NOW + days * DAY)[0]) for days in (1, 366, 368)]
    assert found[:2] == [first, first] != found[1:]
    assert (tmp_path / AUTHORITY).read_bytes() == authority
    assert b"PRIVATE KEY" in key.read_bytes()


def test_a_certificate_is_made_anew_for_another_address_but_not_for_one_less(tmp_path: Path) -> None:
    first = serial(renew_certificate(tmp_path, "door", HOSTS, NOW)[0])
    assert serial(renew_certificate(tmp_path, "door", HOSTS[:1], NOW)[0]) == first
    certificate, _ = renew_certificate(tmp_path, "door", [*HOSTS, "fd00::2"], NOW)
    assert serial(certificate) != first
    names = x509.load_pem_x509_certificate(certificate.read_bytes()).extensions
    assert len(names.get_extension_for_class(x509.SubjectAlternativeName).value) == 4


@pytest.mark.parametrize("name", ["door.crt", AUTHORITY, "authority.key"])
def test_a_damaged_file_is_said_and_not_replaced(tmp_path: Path, name: str) -> None:
    """Devices that know an authority would not know another one."""
    renew_certificate(tmp_path, "door", HOSTS, NOW)
    if name != "door.crt":
        (tmp_path / "door.crt").unlink()
    (tmp_path / name).write_text("nothing")
    with pytest.raises(UsageError, match="remove its files"):
        renew_certificate(tmp_path, "door", HOSTS, NOW)
    assert (tmp_path / name).read_text() == "nothing"
