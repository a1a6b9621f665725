"""``homebot router``: the Zenoh router alone, until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
import json
import socket
import time
from contextlib import AsyncExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self, final

from anyio import to_thread
from pydantic import SecretStr

from homebot.cli.arguments import DEFAULT_CONFIG, add_log_format, add_time_limit, set_command
from homebot.cli.commands.config import plan_of
from homebot.cli.serve import on_an_event_loop, serve
from homebot.errors import UsageError
from homebot.log import configure_logging
from homebot.plugins import check_extra
from homebot.support.data_folder import data_directory
from homebot.support.logger import get_logger
from homebot.support.output import queued_output
from homebot.support.owner_token import OWNER_FILE, make_owner_token

if TYPE_CHECKING:
    from homebot.bridges.zenoh.rights import WireRights
    from homebot.messages.interfaces.settings import RosSettings

SERVING = "router.serving"
NOT_RELOADED = "router.not_reloaded"

_log = get_logger(node="/router")

_EXAMPLES = """\
  homebot router                                  at the address `listen` of [ros] in homebot.toml
  homebot router --certificate villa.lan          make router.crt and router.key, for `listen = "tls/0.0.0.0:7447"`

Robots log in with the names and secrets of their tokens, and may do what `import` and `export` say. The homebot of the
same homebot.toml logs in as the owner if `connect` has the address too. SIGHUP reads the file again.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _router, _EXAMPLES)
    parser.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")
    parser.add_argument(
        "--certificate",
        metavar="NAME",
        nargs="*",
        help="only make a certificate next to the configuration, for these names and addresses of this computer "
        "(default: its host name, also with .local)",
    )
    add_log_format(parser)
    add_time_limit(parser)


def _router(options: argparse.Namespace) -> int:
    path = Path(options.config)
    if options.certificate is not None:
        return _make_certificate(path.parent, options.certificate)
    with queued_output():
        configure_logging(options.log_format)
        router = _Router(path)
        on_an_event_loop(serve(router, options.seconds, reload=router.reload))
    return 0


def _make_certificate(folder: Path, names: list[str]) -> int:
    check_extra("homebot router --certificate", "ros2", "cryptography")
    from homebot.features.ros2.certificate import make_certificate  # noqa: PLC0415 - seldom

    host = socket.gethostname()
    known = names or [host, f"{host.removesuffix('.local')}.local"]
    files = folder / "router.crt", folder / "router.key"
    make_certificate(*files, known, time.time())
    cert_file, key_file = (json.dumps(file.name) for file in files)
    print(f"{files[0]} is for {', '.join(known)} and this computer; {files[1]}, which only you can read, is its key")
    print(
        f'add to [ros] in homebot.toml:\n\nlisten = "tls/0.0.0.0:7447"\ncert_file = {cert_file}\nkey_file = {key_file}'
    )
    print(f"\nrobots need a copy of {files[0].name}: root_ca_certificate of Zenoh, or `ca` of [ros] of another homebot")
    return 0


@final
class _Router:
    """The router with the configuration in *path*, opened again when that changes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._stack = AsyncExitStack()
        self._made: tuple[RosSettings, WireRights]

    async def __aenter__(self) -> Self:
        await self._open(await to_thread.run_sync(self._read))
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    async def reload(self) -> None:
        """Read the configuration again; with a mistake in it, the router goes on as before."""
        try:
            made = await to_thread.run_sync(self._read)
        except UsageError as exc:
            _log.error(NOT_RELOADED, message=f"nothing was reloaded: {exc}")
            return
        if made != self._made:
            await self._stack.aclose()
            await self._open(made)

    async def _open(self, made: tuple[RosSettings, WireRights]) -> None:
        from homebot.bridges.zenoh.session import open_session  # noqa: PLC0415 - after the configuration is checked

        self._made = settings, rights = made
        await self._stack.enter_async_context(open_session(settings, rights))
        users = ", ".join(rights.passwords)
        message = f"Zenoh router listening on {settings.listen}; may log in: {users}; press Ctrl-C to stop"
        _log.info(SERVING, message=message, address=settings.listen, users=[*rights.passwords])

    def _read(self) -> tuple[RosSettings, WireRights]:
        plan = plan_of(self._path)
        if plan.link is None or not plan.link.listen:
            problem = 'has no listen in [ros]; write listen = "tcp/127.0.0.1:7447", or see homebot router --help'
            raise UsageError(f"{self._path} {problem}")
        from homebot.runtime.session_keeper import read_rights  # noqa: PLC0415 - once Zenoh is known to be installed

        owner = make_owner_token(data_directory() / OWNER_FILE)
        settings = plan.link.model_copy(update={"connect": ()})
        return settings, read_rights(plan, settings, time.time(), SecretStr(owner.secret))
