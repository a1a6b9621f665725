"""The files of the page, as the door serves them: no secret is in them, and nothing is loaded from anywhere else."""

import gzip
import hashlib
import json
import re
from collections.abc import Mapping
from functools import cache
from http import HTTPStatus
from importlib.resources import files
from pathlib import Path
from typing import Final

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.outcomes import OUTCOMES
from homebot.devices.wording.values import flag_texts

_TYPES: Final = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".webmanifest": "application/manifest+json",
}
"""Types by the ends of names."""

_INDEX: Final = "index.html"
_VOCABULARY: Final = "vocabulary.json"
_WORKER: Final = "worker.js"

_AUTHORITY: Final = "authority.crt"

_HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "manifest-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
        "require-trusted-types-for 'script'; trusted-types worker"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
    "Vary": "Accept-Encoding",
    "Connection": "close",
}


def answer(
    path: str, etag: str, encodings: str = "", authority: Path | None = None
) -> tuple[HTTPStatus, Mapping[str, str], bytes] | None:
    """Return status, headers and body for *path*; None for an unknown path.

    Args:
        etag: The header ``If-None-Match``.
        encodings: The header ``Accept-Encoding``; a text is compressed for a browser that takes gzip.
        authority: The folder of the local authority, whose certificate is a file of the page; None for none.
    """
    name = path.partition("?")[0].removeprefix("/")
    if name == _AUTHORITY and authority is None:
        return HTTPStatus.NO_CONTENT, {**_HEADERS, "Content-Length": "0"}, b""
    if name == _AUTHORITY and authority is not None:
        body = (authority / name).read_bytes()
        kind, length = "application/x-x509-ca-cert", str(len(body))
        return HTTPStatus.OK, {**_HEADERS, "Content-Type": kind, "Content-Length": length}, body
    if name == _INDEX or (name or _INDEX) not in _names():
        return None
    name = name or _INDEX
    is_packed = "gzip" in [encoding.strip() for encoding in encodings.split(",")] and not name.endswith(".png")
    own, body = _file(name, is_packed=is_packed)
    headers = {**_HEADERS, "ETag": own, **({"Content-Encoding": "gzip"} if is_packed else {})}
    if etag == own:
        return HTTPStatus.NOT_MODIFIED, {**headers, "Content-Length": "0"}, b""
    return HTTPStatus.OK, {**headers, "Content-Type": _TYPES[Path(name).suffix], "Content-Length": str(len(body))}, body


@cache
def build() -> str:
    """Return the name of this build of the page, which its files tell: it changes with any of them."""
    digests = [f"{name} {hashlib.sha256(_shipped(name)).hexdigest()}" for name in _names()]
    return hashlib.sha256("\n".join(digests).encode()).hexdigest()[:16]


@cache
def _names() -> tuple[str, ...]:
    shipped = [file.name for file in files("homebot.web").joinpath("page").iterdir() if file.is_file()]
    return tuple(sorted([*(name for name in shipped if Path(name).suffix in _TYPES), _VOCABULARY]))


@cache
def _file(name: str, *, is_packed: bool) -> tuple[str, bytes]:
    body = _shipped(name)
    if name == _INDEX:  # what the page's first line imports is asked for with it
        early = re.findall(rb"\./([\w-]+\.js)", _shipped("page.js"))
        links = b"".join(b'<link rel="modulepreload" href="%s" />' % file for file in early)
        body = body.replace(b"{build}", build().encode()).replace(b"</head>", links + b"</head>")
    if name == _WORKER:  # a browser takes a worker for a new one if its text differs
        shell = [file for file in _names() if file != _WORKER]
        body = f"const BUILD = {json.dumps(build())}, FILES = {json.dumps(shell)};\n".encode() + body
    body = gzip.compress(body, mtime=0) if is_packed else body
    return f'"{hashlib.sha256(body).hexdigest()[:32]}"', body


@cache  # an update replaces the files of a running homebot
def _shipped(name: str) -> bytes:
    return _vocabulary() if name == _VOCABULARY else files("homebot.web").joinpath("page", name).read_bytes()


def _vocabulary() -> bytes:
    """Return units, words for no and yes and only reported texts by capability, and the outcomes that are failures."""
    known = CAPABILITIES.items()
    return json.dumps(
        {
            "units": {name: capability.unit for name, capability in known if capability.unit},
            "flags": {name: flag_texts(name) for name, capability in known if capability.kind == "bool"},
            "passing": {
                name: sorted(capability.only_reported) for name, capability in known if capability.only_reported
            },
            "failures": [kind for kind, outcome in OUTCOMES.items() if outcome.is_failure],
        }
    ).encode()
