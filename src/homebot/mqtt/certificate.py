"""Loading of a certificate and key for this side of TLS."""

import ssl
from pathlib import Path
from typing import Final

from homebot.errors import UsageError

_NO_PASSPHRASE: Final = "-"  # noqa: S105 - no secret; given none, OpenSSL asks for one on the terminal


def load_certificate(
    context: ssl.SSLContext, cert_file: Path, key_file: Path | None, *, what: str, key_option: str
) -> None:
    """Let *context* present the certificate in *cert_file*.

    Args:
        key_file: Its key in PEM form, without a passphrase; None if *cert_file* contains it too.
        what: Name of the certificate in errors, such as ``client certificate``.

    Raises:
        UsageError: A file cannot be read or is invalid; the message names it.
    """
    certificate = _read(what, cert_file)
    key = certificate if key_file is None else _read(f"key of the {what}", key_file)
    try:
        context.load_cert_chain(cert_file, key_file, password=_NO_PASSPHRASE)
    except (OSError, ssl.SSLError) as error:
        where = key_file or cert_file
        if b"-----BEGIN CERTIFICATE" not in certificate:
            problem = f"no certificate was found in {cert_file}"
        elif b"PRIVATE KEY-----" not in key:
            problem = f"no key was found in {where}{f'; set {key_option}' if key_file is None else ''}"
        elif b"ENCRYPTED" in key:
            problem = f"the key in {where} is locked with a passphrase; homebot needs one without"
        else:
            problem = f"the key in {where} does not match the certificate in {cert_file}, or cannot be read"
        raise UsageError(f"{what}: {problem}") from error


def _read(what: str, path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(f"{what} {path}: {error.strerror}") from error
