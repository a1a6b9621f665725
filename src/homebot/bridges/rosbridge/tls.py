"""TLS of the rosbridge server: by a certificate of the owner's, or by one of a local authority that homebot makes once.

A browser trusts the page once the device knows the authority, whose certificate the page offers; then the certificate
of the server may change as often as the computer's addresses do.
"""

import socket
import ssl
from pathlib import Path
from typing import Final, final

import anyio
from anyio import to_thread

from homebot.bridges.rosbridge.settings import RosbridgeSettings
from homebot.clock import Clock
from homebot.errors import UsageError
from homebot.mqtt.certificate import load_certificate
from homebot.plugins import check_extra
from homebot.support.addresses import is_loopback, parse_address
from homebot.support.logger import get_logger
from homebot.support.own_addresses import own_addresses

NOT_RENEWED: Final = "door.certificate_not_renewed"

_CHECK_EVERY: Final = 3600.0
"""Seconds after which the certificate is looked at again, as its end or another address may have come."""

_log = get_logger(node="/rosbridge_websocket")


@final
class ServerTls:
    """The certificate of the rosbridge server.

    Args:
        folder: Where the authority and its certificate are kept; None where homebot keeps no data.

    Attributes:
        context: The side of TLS that listens; a new certificate is for connections from then on.

    Raises:
        UsageError: A file cannot be read or written, or homebot keeps no data.
    """

    def __init__(self, settings: RosbridgeSettings, folder: Path | None, clock: Clock) -> None:
        self._settings, self._clock, self._folder = settings, clock, folder
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._loaded: float | None = None
        self.refresh()

    def refresh(self) -> None:
        """Make or renew the certificate if it is time, and load it if its file has changed. Blocking.

        Raises:
            UsageError: As for the class.
        """
        certificate, key = self._settings.certificate, self._settings.key
        if certificate is None:
            certificate, key = self._own_certificate()
        changed = certificate.stat().st_mtime if certificate.exists() else None
        if changed is None or changed != self._loaded:
            load_certificate(self.context, certificate, key, what="[door] certificate", key_option="key")
            self._loaded = changed

    async def run(self) -> None:
        """Keep the certificate fresh until cancelled."""
        while True:
            await anyio.sleep(_CHECK_EVERY)
            try:
                await to_thread.run_sync(self.refresh)
            except UsageError as exc:  # that in use is good for a while
                _log.error(NOT_RENEWED, message=f"the certificate of the door cannot be renewed: {exc}")

    def _own_certificate(self) -> tuple[Path, Path]:
        check_extra("[door] tls", "tls", "cryptography")
        from homebot.support.authority import renew_certificate  # noqa: PLC0415 - an extra

        if self._folder is None:
            raise UsageError("[door] tls keeps its authority with homebot's data, and this run keeps none")
        try:
            name = socket.gethostname()
            hosts = ["localhost", "127.0.0.1", "::1", name, f"{name.removesuffix('.local')}.local"]
            if not is_loopback(self._settings.host):
                hosts += [self._settings.host, *own_addresses()]
            addresses = {name: parse_address(name) for name in hosts if name}
            return renew_certificate(
                self._folder,
                "door",
                [name for name, address in addresses.items() if address is None or not address.is_unspecified],
                self._clock.now(),
            )
        except OSError as exc:
            raise UsageError(f"[door] tls: {exc.filename} cannot be written: {exc.strerror}") from exc
