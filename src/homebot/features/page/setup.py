"""The setup by the page: gateways for found devices, people, addresses of alerts, tokens. Each step writes the file.

Changes come one after the other. One that homebot refuses leaves the file as it was.
"""

from __future__ import annotations

import asyncio
import json
import tomllib
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, NamedTuple, TypeAlias, final
from urllib.parse import urlsplit

import anyio
from anyio import to_thread

from homebot.config import Config, parse_config
from homebot.conventions.ecosystem import ecosystems
from homebot.devices.app_messages import Reload, ReloadRequest
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import NEEDS_GATEWAY, NEXT_STEP, RELOAD, PairingNames, gateway_of
from homebot.errors import ConfigError, HomebotError, UsageError
from homebot.feature import feature_tables
from homebot.features.page import CHANGE_SETUP, FIND_UNUSED, GET_BACKUP, READ_TABLE
from homebot.features.page.backups import Backups
from homebot.features.page.setup_messages import (
    ChangeSetup,
    ChangeSetupRequest,
    ChangeSetupResponse,
    FindUnused,
    FindUnusedRequest,
    FindUnusedResponse,
    GetBackup,
    MakeToken,
    MakeTokenRequest,
    MakeTokenResponse,
    ReadTable,
    ReadTableRequest,
    ReadTableResponse,
    UnpairedOfGateway,
    UnusedDevices,
)
from homebot.features.page.shown_addresses import hidden_in, shown, stated
from homebot.gateways.pairing import ListUnpaired, UnpairedRequest
from homebot.graph import EntityKind, Node
from homebot.messages.key_value import KeyValue
from homebot.runtime.declared_secrets import keys_of_tables, secrets_of
from homebot.support.file_access import replace_file
from homebot.support.key_roles import DeclaredKey, KeyRole
from homebot.support.toml_edit import REMOVED, edit_toml
from homebot.support.toml_file import parse_toml

_TABLES: Final = frozenset({"discovery", "gateways", "home", "notify", "places"})
"""The first names of tables of the core that may be changed: none that runs programs, or has rights and policies."""

_WITH_SECRETS: Final = {("gateways",)}
"""Tables with secrets that are no addresses, and with addresses without any."""

_SECRETS: Final = frozenset({"password", "token"})
_MAX_NAME: Final = 64
_BROKER: Final = ("mqtt", 1883)
"""The scheme and the usual port of a broker, which is looked for on this computer as the servers of ecosystems are."""

_LOOK_FOR_S: Final = 1.0
_LEAVE_AFTER_S: Final = 0.5
"""Time for an answer to be sent before homebot begins again."""

_MAX_SHOWN: Final = 200
_PATIENCE_S: Final = 60.0


class _Step(NamedTuple):
    """A change: the text before it and after it, and the old content of the files of its secrets; None for no file."""

    before: str
    after: str
    secrets: Mapping[Path, bytes | None]


@final
class Setup:
    """Finds devices that no gateway uses, changes the configuration, and makes tokens.

    Args:
        file: Returns the file of the configuration; None if homebot runs without one. Called in a thread.
        restart: Ends the run, and begins another; None where only a person can.
        listens: Returns whether a program on this computer listens on a port; by default it is tried.
    """

    def __init__(
        self,
        node: Node,
        file: Callable[[], Path | None],
        restart: Callable[[], None] | None,
        listens: Callable[[int], Awaitable[bool]] | None,
    ) -> None:
        self._node = node
        self._file = file
        self._restart = restart
        self._listens = listens or _listens_here
        self._lookup = DeviceLookup(node)
        self._last: _Step | None = None

    def serve(self, name: str) -> None:
        """Create the service *name*."""
        if name == FIND_UNUSED.name:
            self._node.create_service(FindUnused, name, self._find, concurrent=True)
        elif name == CHANGE_SETUP.name:
            self._node.create_service(ChangeSetup, name, self._change)
        elif name == READ_TABLE.name:
            self._node.create_service(ReadTable, name, self._read, concurrent=True)
        elif name == GET_BACKUP.name:
            self._node.create_service(GetBackup, name, Backups(self._node, self._path).get)
        else:
            self._node.create_service(MakeToken, name, self._make_token)

    async def _find(self, _: FindUnusedRequest) -> FindUnusedResponse:
        found: dict[tuple[str, str], dict[str, str]] = {}
        for device in await self._lookup.devices():
            facts = {
                fact.name: fact.value for fact in reversed(device.facts) if fact.name in {NEEDS_GATEWAY, NEXT_STEP}
            }
            if NEEDS_GATEWAY in facts:
                found.setdefault((facts[NEEDS_GATEWAY], facts.get(NEXT_STEP, "")), {})[device.id] = device.name
        unused = tuple(
            UnusedDevices(
                gateway=gateway, devices=(*names,)[:_MAX_SHOWN], names=(*names.values(),)[:_MAX_SHOWN], next=step
            )
            for (gateway, step), names in sorted(found.items())
        )
        file = await to_thread.run_sync(self._file)
        tables = await to_thread.run_sync(_gateways_in, file)
        gateways = {*filter(None, map(gateway_of, self._node.graph.get_node_names()))} - feature_tables().keys()
        servers = {"mqtt": _BROKER} | {one.gateway: one.server for one in ecosystems() if one.server is not None}
        for gateway, (scheme, port) in servers.items():
            if gateway not in gateways | tables.keys() and await self._listens(port):
                url = f"{scheme}://127.0.0.1:{port}"
                unused += (UnusedDevices(gateway=gateway, devices=(), names=(), next="", url=url),)
        return FindUnusedResponse(
            unused=unused,
            unpaired=tuple([one async for one in self._find_unpaired(gateways)]),
            file=str(file or ""),
            gateways=tuple(sorted(gateways)),
            acting=tuple(
                name for name, table in tables.items() if isinstance(table, dict) and table.get("act") is True
            ),
            can_restart=self._restart is not None,
        )

    async def _find_unpaired(self, gateways: Iterable[str]) -> AsyncIterator[UnpairedOfGateway]:
        for gateway in sorted(gateways):
            name = PairingNames(gateway).unpaired
            if self._node.graph.get_endpoints(kind=EntityKind.SERVICE, name=name):
                answer = await self._node.create_client(ListUnpaired, name).call(UnpairedRequest())
                for one in answer.devices:
                    yield UnpairedOfGateway(gateway=gateway, unpaired=one)

    async def _read(self, request: ReadTableRequest) -> ReadTableResponse:
        try:
            table = await to_thread.run_sync(self._table, request.table)
        except (HomebotError, OSError) as exc:
            return ReadTableResponse(success=False, message=str(exc))
        values = (KeyValue(key=key, value=json.dumps(value, default=str)) for key, value in table.items())
        return ReadTableResponse(success=True, message="", values=tuple(values))

    def _table(self, names: tuple[str, ...]) -> dict[str, object]:
        if names[:1] in _WITH_SECRETS:
            raise UsageError("the table of a gateway has secrets, so a page does not read it")
        _check_table(names)
        path = self._path()
        tables = tomllib.loads(path.read_text("utf-8"))
        found = shown(_in(tables, names), _secrets_in(tables, path))
        return found if isinstance(found, dict) else {}

    async def _change(self, request: ChangeSetupRequest) -> ChangeSetupResponse:
        if request.restart:
            if self._restart is None:
                return ChangeSetupResponse(
                    success=False, message="this run cannot begin again by itself; start it again"
                )
            asyncio.get_running_loop().call_later(_LEAVE_AFTER_S, self._restart)
            return ChangeSetupResponse(success=True)
        try:
            step = await to_thread.run_sync(self._write, request)
        except (HomebotError, OSError) as exc:
            return ChangeSetupResponse(success=False, message=str(exc))
        may_lose = request.undo or bool(request.remove)
        answer = await self._reload(may_lose=may_lose)
        if not answer.success:
            await to_thread.run_sync(self._put, step.after, step.before)
            await to_thread.run_sync(_put_secrets, step.secrets)
            self._last = None
            await self._reload(may_lose=True)
            return ChangeSetupResponse(success=False, message=f"the file is as it was: {answer.message}")
        self._last = step
        known = step.before.splitlines()
        lines = [line for line in step.after.splitlines() if line and line not in known]
        lines = await to_thread.run_sync(self._hidden, lines, step.after, request.table)
        return ChangeSetupResponse(success=True, message=answer.message, lines=tuple(lines[:_MAX_SHOWN]))

    def _hidden(self, lines: list[str], text: str, table: tuple[str, ...]) -> list[str]:
        tables = tomllib.loads(text)
        addresses = {} if table[:1] in _WITH_SECRETS else _in(tables, table)
        return hidden_in(lines, addresses, _secrets_in(tables, self._path()))

    async def _reload(self, *, may_lose: bool) -> Any:
        reload = self._node.create_client(Reload, RELOAD)
        return await reload.call(ReloadRequest(allow_removal=may_lose), timeout=_PATIENCE_S)

    def _write(self, request: ChangeSetupRequest) -> _Step:
        """Write the change."""
        path = self._path()
        text = path.read_text("utf-8")
        if request.undo:
            if self._last is None or self._last.after != text:
                raise UsageError("there is nothing to undo, or the file was changed since")
            after, secrets = self._last.before, dict(self._last.secrets)
        else:
            after, secrets = _edit(text, request, path)
        kept = {file: file.read_bytes() if file.exists() else None for file in secrets}
        _put_secrets(secrets)
        try:
            self._put(text, after)
        except (HomebotError, OSError):
            _put_secrets(kept)
            raise
        return _Step(text, after, kept)

    def _put(self, before: str, after: str) -> None:
        """Replace the file, with its rights, if it still has the text *before*."""
        path = self._path()
        if path.read_text("utf-8") != before:
            raise UsageError(f"{path} was changed meanwhile; look at it, and try again")
        replace_file(path, after.encode())

    def _path(self) -> Path:
        path = self._file()
        if path is None:
            raise UsageError("homebot runs without a file of its configuration; start it in a folder with homebot.toml")
        return path

    async def _make_token(self, request: MakeTokenRequest) -> MakeTokenResponse:
        try:
            _check_rights(request)
            token = await to_thread.run_sync(self._add_token, request)
        except HomebotError as exc:
            return MakeTokenResponse(success=False, message=str(exc))
        answer = await self._reload(may_lose=False)
        return MakeTokenResponse(success=answer.success, message=answer.message, token=token if answer.success else "")

    def _add_token(self, request: MakeTokenRequest) -> str:
        from homebot.cli.commands.token import add_token  # noqa: PLC0415 - few runs make one

        _, _, secret = add_token(self._path(), request.name, request.grants)
        return secret


async def _listens_here(port: int) -> bool:
    """Return whether a program on this computer listens on *port*."""
    with anyio.move_on_after(_LOOK_FOR_S):
        try:
            stream = await anyio.connect_tcp("127.0.0.1", port)
        except OSError:
            return False
        await stream.aclose()
        return True
    return False


def _gateways_in(file: Path | None) -> Mapping[str, object]:
    tables = tomllib.loads(file.read_text("utf-8")).get("gateways", {}) if file is not None else {}
    return tables if isinstance(tables, dict) else {}


def _edit(text: str, request: ChangeSetupRequest, path: Path) -> tuple[str, dict[Path, bytes | None]]:
    """Return *text* of the file *path* after a change, and the files for its secrets with their content."""
    table = request.table
    _check_table(table or request.remove[:1])
    given = _secret_files(request, path.parent)
    names = {f"{key}_file": file.name for key, (file, _) in given.items()}
    tables = tomllib.loads(text)
    used, secrets = _in(tables, table), _secrets_in(tables, path)
    values = {
        key: value if value is REMOVED else stated(value, used, secrets) for key, value in _values(request).items()
    }
    after = edit_toml(text, table, values | names)
    try:
        changed = _parsed(tomllib.loads(after), path)
    except ConfigError as exc:
        raise UsageError(f"the file is as it was: {exc}") from exc
    _check_peers(_parsed(tables, path), changed, {*names.values()})
    for key, (file, _) in given.items():
        if file.exists() and used.get(f"{key}_file") != file.name:
            raise UsageError(f"{file} is there already; remove it, or give the gateway another name")
    return after, dict(given.values())


def _check_peers(before: Config, after: Config, given: Collection[str]) -> None:
    """Raise UsageError if a secret of *before* would be sent to another peer, and is not *given* anew for it."""
    known: dict[str, set[_Peers]] = {}
    for key, peers in _peers_of_secrets(before):
        known.setdefault(key.value, set()).add(peers)
    for key, peers in _peers_of_secrets(after):
        if key.value in given or peers in known.get(key.value, ()):
            continue
        if key.value in known:
            problem = "is for the address that is there; give it again with the other one"
        elif key.role is KeyRole.SECRET:  # it came with the change
            continue
        else:
            problem = "names a secret of this computer; only a person writes it into the file"
        raise UsageError(f"{key.key} of [{'.'.join(key.table)}] {problem}")


_Peers: TypeAlias = frozenset[tuple[str, tuple[str, str | None, int | None] | str]]


def _peers_of_secrets(config: Config) -> Iterator[tuple[DeclaredKey, _Peers]]:
    """Yield each secret, or the name of one, with where it is sent."""
    for keys in keys_of_tables(config):
        for key in keys:
            if key.role not in {KeyRole.PUBLIC, KeyRole.PEER}:
                beside = (one for one in keys if one.table == key.table and one.role is KeyRole.PEER)
                yield key, frozenset((one.key, _server_of(one.value)) for one in beside)


def _server_of(address: str) -> tuple[str, str | None, int | None] | str:
    """Return scheme, host and port of a URL; another *address* as it is."""
    with suppress(ValueError):
        parts = urlsplit(address)
        if parts.netloc:
            return parts.scheme, parts.hostname, parts.port
    return address


def _parsed(tables: Mapping[str, object], path: Path) -> Config:
    return parse_config(tables, str(path), path.parent)


def _secrets_in(tables: Mapping[str, object], path: Path) -> Collection[str]:
    return secrets_of(_parsed(tables, path), tables).texts


def _check_table(table: tuple[str, ...]) -> None:
    """Raise UsageError if a page may not change *table*."""
    changeable = _TABLES | {key for key, of_feature in feature_tables().items() if of_feature.is_on_page}
    if not table or table[0] not in changeable or not all(table):
        listed = ", ".join(sorted(changeable))
        raise UsageError(f"the table {'.'.join(table)!r} is not among those that a page may change: {listed}")


def _in(tables: object, names: tuple[str, ...]) -> dict[str, object]:
    """Return the table with these *names* in *tables*; empty if it is not there."""
    for name in names:
        tables = tables.get(name) if isinstance(tables, dict) else None
    return tables if isinstance(tables, dict) else {}


def _secret_files(request: ChangeSetupRequest, folder: Path) -> Mapping[str, tuple[Path, bytes]]:
    """Return the files of the secrets with their content, by key."""
    table = request.table
    if request.secrets and not (len(table) == len(("gateways", "NAME")) and table[0] == "gateways"):
        raise UsageError("only the table of a gateway takes a password or a token")
    found = {}
    for pair in request.secrets:
        if pair.key not in _SECRETS or not pair.value.isprintable() or not _is_file_name(table[-1]):
            raise UsageError(f"{pair.key[:40]!r} of {'.'.join(table)[:100]} cannot be kept in a file of its own")
        found[pair.key] = folder / f"gateway-{table[-1]}.{pair.key}", f"{pair.value}\n".encode()
    return found


def _is_file_name(text: str) -> bool:
    letters = text.replace("-", "").replace("_", "")
    return len(text) <= _MAX_NAME and letters.isascii() and letters.isalnum()


def _put_secrets(secrets: Mapping[Path, bytes | None]) -> None:
    """Write the files, which only their owner can read; None removes one."""
    for file, value in secrets.items():
        if value is None:
            file.unlink(missing_ok=True)
        else:
            file.touch(0o600)
            file.chmod(0o600)
            file.write_bytes(value)


def _values(request: ChangeSetupRequest) -> dict[str, object]:
    values: dict[str, object] = dict.fromkeys(request.remove, REMOVED)
    for pair in request.values:
        try:
            (value,) = parse_toml(f"x = {pair.value}", "").values()
        except (ConfigError, ValueError):  # also for several values
            raise UsageError(f"{pair.key} = {pair.value[:100]} is no value of TOML; texts need quotes") from None
        values[pair.key] = value
    for key in _keys_in(values):
        if key == "class" or key.endswith("_file"):
            raise UsageError(f"the key {key} loads a program or a file; only a person writes it into the file")
    return values


def _keys_in(value: object) -> Iterator[str]:
    """Yield the keys of tables in *value*, at any depth."""
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _keys_in(inner)
    if isinstance(value, dict):
        yield from value


def _check_rights(request: MakeTokenRequest) -> None:
    """Raise UsageError if the token would have a right that the client lacks."""
    own = {*request.scope, "read", "manage"}  # it has these two, as it may call this
    for right in request.grants:
        word = right.partition(":")[0].strip()
        is_own = right in own or (word in {"act", "ask"} and "act: all" in own)
        if not is_own:
            raise UsageError(f"the right {right!r} is none that you may give; use: homebot token new")
