"""Certificate files, and what can be wrong with them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.tls import make_tls_context


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a certificate, its key, the same key locked, and a key of somebody else."""
    if shutil.which("openssl") is None:
        pytest.skip("openssl is not installed")
    folder = tmp_path_factory.mktemp("files")
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-days", "2"]
    for command in (
        ["req", "-x509", *curve, "-nodes", "-keyout", "me.key", "-out", "me.pem", "-subj", "/CN=me"],
        ["req", "-x509", *curve, "-nodes", "-keyout", "other.key", "-out", "other.pem", "-subj", "/CN=other"],
        ["pkcs8", "-topk8", "-in", "me.key", "-out", "locked.key", "-passout", "pass:hunter2"],
    ):
        subprocess.run(["openssl", *command], cwd=folder, check=True, capture_output=True)
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
        ("me.pem", "other.key", r"the key in \S*other\.key does not fit the certificate in \S*me\.pem"),
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
