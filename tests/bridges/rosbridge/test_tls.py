"""The door with TLS: by its own authority, or by a certificate of the owner's."""

import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
import trustme
from anyio import to_thread
from pydantic import ValidationError
from tests.patience import PATIENCE

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.tls import ServerTls
from homebot.cli.door_client import open_door
from homebot.cli.server_address import ServerAddress
from homebot.clock import ManualClock
from homebot.config import parse_config
from homebot.errors import LinkError, UsageError
from homebot.runtime import Runtime


@asynccontextmanager
async def running(folder: Path, **door: object) -> AsyncIterator[int]:
    """Run homebot with its data in *folder*; give the port of its door."""
    config = parse_config({"door": {"port": 0, **door}}, "test")
    async with Runtime(config, owner_file=folder / "owner.token") as runtime:
        assert runtime.rosbridge is not None
        assert runtime.rosbridge.page.startswith("https://")
        yield runtime.rosbridge.port


async def page_of(port: int, context: ssl.SSLContext, path: str = "/") -> bytes:
    with anyio.fail_after(PATIENCE):
        async with await anyio.connect_tcp(
            "127.0.0.1", port, tls=True, ssl_context=context, tls_hostname="localhost", tls_standard_compatible=False
        ) as stream:
            await stream.send(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            found = b""
            async for piece in stream:
                found += piece
            return found


@pytest.mark.newest("tls")
async def test_the_page_and_the_command_line_trust_the_authority_that_homebot_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path))
    async with running(tmp_path, tls=True) as port:
        context = ssl.create_default_context(cafile=tmp_path / "door" / "authority.crt")
        assert b"200 OK" in await page_of(port, context)
        offered = await page_of(port, context, "/authority.crt")
        assert offered.endswith((tmp_path / "door" / "authority.crt").read_bytes())
        assert b"application/x-x509-ca-cert" in offered
        with pytest.raises(ssl.SSLCertVerificationError):
            await page_of(port, ssl.create_default_context())

        def ask(*, has_tls: bool) -> object:
            with open_door(ServerAddress("127.0.0.1", port, has_tls=has_tls)) as door:
                return door.call("/discovery/list", {})["total"]

        assert await to_thread.run_sync(lambda: ask(has_tls=True)) == 0
        with pytest.raises(LinkError, match="wss://HOST:PORT if it has TLS"):
            await to_thread.run_sync(lambda: ask(has_tls=False))


def write_certificate(authority: trustme.CA, folder: Path) -> tuple[Path, Path]:
    """Write a certificate of the owner's and its key; return their files."""
    made, files = authority.issue_cert("localhost"), (folder / "house.crt", folder / "house.key")
    files[0].write_bytes(b"".join(one.bytes() for one in made.cert_chain_pems))
    files[1].write_bytes(made.private_key_pem.bytes())
    return files


async def test_a_certificate_of_the_owner_is_used(tmp_path: Path) -> None:
    authority, context = trustme.CA(), ssl.create_default_context()
    authority.configure_trust(context)
    file, key = await to_thread.run_sync(write_certificate, authority, tmp_path)
    async with running(tmp_path, certificate=str(file), key=str(key)) as port:
        assert b"200 OK" in await page_of(port, context)
        assert b"200 OK" not in await page_of(port, context, "/authority.crt")


def test_a_certificate_that_was_renewed_is_read_again(tmp_path: Path) -> None:
    authority = trustme.CA()
    file, key = write_certificate(authority, tmp_path)
    tls = ServerTls(RosbridgeSettings(certificate=file, key=key), None, ManualClock())
    write_certificate(authority, tmp_path)
    tls.refresh()
    file.write_text("nothing")
    with pytest.raises(UsageError, match="no certificate was found"):
        tls.refresh()


def test_what_cannot_be_used_is_said(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="this run keeps none"):
        ServerTls(RosbridgeSettings(tls=True), None, ManualClock())
    with pytest.raises(UsageError, match="No such file"):
        ServerTls(RosbridgeSettings(certificate=tmp_path / "absent.crt"), None, ManualClock())
    with pytest.raises(ValidationError, match="state certificate too"):
        RosbridgeSettings(key=tmp_path / "house.key")
