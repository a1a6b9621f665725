"""Certificate files, and what can be wrong with them."""

from pathlib import Path

import pytest
import trustme
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    PrivateFormat,
    load_pem_private_key,
)

from homebot.errors import UsageError
from homebot.mqtt.client.tcp_transport import make_tls_context
from homebot.mqtt.options import MqttOptions


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a certificate, its key, the same key locked, and a key of somebody else."""
    folder = tmp_path_factory.mktemp("files")
    authority = trustme.CA()
    for name in ("me", "other"):
        issued = authority.issue_cert("127.0.0.1", common_name=name)
        issued.private_key_pem.write_to_path(folder / f"{name}.key")
        issued.cert_chain_pems[0].write_to_path(folder / f"{name}.pem")
    key = load_pem_private_key((folder / "me.key").read_bytes(), password=None)
    locked = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(b"hunter2"))
    (folder / "locked.key").write_bytes(locked)
    (folder / "empty.pem").write_text("nothing")
    return folder


@pytest.mark.parametrize(
    ("content", "problem"), [(None, "No such file"), ("nothing", "no certificate was found in it")]
)
async def test_a_ca_file_that_cannot_be_used_is_named(tmp_path: Path, content: str | None, problem: str) -> None:
    path = tmp_path / "ca.pem"
    if content is not None:
        path.write_text(content)
    with pytest.raises(UsageError, match=rf"CA file .*ca\.pem: {problem}"):
        await make_tls_context(MqttOptions.from_url("mqtts://broker", ca_file=path))


@pytest.mark.parametrize(
    ("certificate", "key", "problem"),
    [
        ("absent.pem", "me.key", r"client certificate .*absent\.pem: No such file"),
        ("me.pem", "absent.key", r"key of the client certificate .*absent\.key: No such file"),
        ("me.pem", None, r"no key was found in \S*me\.pem; set key_file$"),
        ("me.pem", "other.pem", r"no key was found in \S*other\.pem$"),
        ("empty.pem", "me.key", r"no certificate was found in \S*empty\.pem$"),
        ("me.pem", "locked.key", r"the key in \S*locked\.key is locked with a passphrase"),
        ("me.pem", "other.key", r"the key in \S*other\.key does not match the certificate in \S*me\.pem"),
    ],
)
async def test_a_client_certificate_that_cannot_be_used_says_why(
    files: Path, certificate: str, key: str | None, problem: str
) -> None:
    options = MqttOptions.from_url(
        "mqtts://broker", cert_file=files / certificate, key_file=None if key is None else files / key
    )
    with pytest.raises(UsageError, match=problem):
        await make_tls_context(options)


async def test_a_client_certificate_with_its_key_is_read(files: Path) -> None:
    await make_tls_context(MqttOptions.from_url("mqtts://b", cert_file=files / "me.pem", key_file=files / "me.key"))
