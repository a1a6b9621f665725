"""The table ``[door]``, and the access tokens of servers, read from the files that contain them."""

from collections.abc import Mapping
from datetime import datetime, timedelta
from math import inf
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, SecretStr, ValidationError

from homebot.bridges.admission import AccessSettings
from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings, Scope
from homebot.clock import read_zone
from homebot.config import Config, FilePath, SecretFile, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.rights import Right
from homebot.support.addresses import is_loopback
from homebot.support.file_access import read_secret


class RosbridgeTable(RosbridgeSettings):
    """The keys of the table ``[door]``.

    Attributes:
        token_file: File with the token in its first line, readable by its owner only.
    """

    token_file: SecretFile | None = None
    certificate: FilePath | None = None
    key: SecretFile | None = None


def _check_end(text: str) -> str:
    try:
        _end_of(text, "")
    except (ValueError, OverflowError):
        raise ValueError(f"{text[:40]!r} is no date; write it like 2026-12-31 or 2026-12-31 18:00") from None
    return text


class TokenTable(BaseModel):
    """The keys of a table ``[door.tokens.NAME]``.

    Attributes:
        token_file: File with the token in its first line, readable by its owner only.
        until: When it ends: ``2026-12-31``, at the end of that day, or ``2026-12-31 18:00``, in the zone of the home.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    token_file: SecretFile
    scope: Scope
    until: Annotated[str, AfterValidator(_check_end)] = ""


def read_rosbridge_settings(config: Config) -> RosbridgeSettings:
    """Return the rosbridge server's settings, with the tokens read from their files.

    Raises:
        ConfigError: The table is wrong, or a secret cannot be read.
    """
    source = config.source
    table = {key: value for key, value in config.door.items() if key != "tokens"}
    given = parse_settings(RosbridgeTable, table, source, "door", config.folder)
    tokens = _tokens(config.door.get("tokens", {}), config)
    if given.scope:
        from homebot.words.rights import read_scope  # noqa: PLC0415 - few servers have a scope

        if unsafe := read_scope(given.scope).kinds & {Right.MANAGE, Right.RAW}:
            words = " and ".join(sorted(right.value for right in unsafe))
            problem = f"a program without a token may not have {words}; give it one: homebot token new NAME --scope …"
            raise ConfigError(source, "door.scope", problem)
    values = read_access(given, given.token_file, source, "door", "HOMEBOT_DOOR_TOKEN", has_other_tokens=bool(tokens))
    try:
        return RosbridgeTable(**{**values, "tokens": tokens})
    except ValidationError as exc:  # its text would show the secrets
        raise ConfigError(source, "door.tokens", exc.errors()[0]["msg"].removeprefix("Value error, ")) from None


def read_access(
    table: AccessSettings,
    token_file: Path | None,
    source: str,
    key: str,
    variable: str,
    *,
    has_other_tokens: bool = False,
) -> dict[str, Any]:
    """Return the values of the *table* of a server, with the token read from its file or *variable*.

    Raises:
        ConfigError: The token cannot be read, is given twice, or is missing although others can reach the server.
    """
    values = {name: getattr(table, name) for name in table.model_fields_set if name != "token_file"}
    if token_file is not None:
        if table.token is not None:
            raise ConfigError(source, key, "give token or token_file, not both")
        values["token"] = _secret(token_file, source, key)
    if values.get("token") is None and not has_other_tokens and not is_loopback(table.host):
        raise ConfigError(
            source,
            f"{key}.host",
            f"{table.host} can be reached by others, so it needs a token: give token_file, or {variable} in the "
            "environment, or listen on 127.0.0.1",
        )
    return values


def _tokens(tables: object, config: Config) -> dict[str, ClientToken]:
    source = config.source
    if not isinstance(tables, Mapping):
        raise ConfigError(source, "door.tokens", "must be tables, [door.tokens.NAME]")
    tokens = {}
    for name, table in tables.items():
        key = f"door.tokens.{name}"
        if not isinstance(table, Mapping):
            raise ConfigError(source, key, f"must be a table, [{key}]")
        given = parse_settings(TokenTable, table, source, key, config.folder)
        tokens[str(name)] = ClientToken(
            token=_secret(given.token_file, source, key),
            scope=given.scope,
            until=_end_of(given.until, config.home.zone) if given.until else inf,
        )
    return tokens


def _end_of(text: str, zone: str) -> float:
    """Return the moment *text* in seconds since 1970; for a date without a time the end of that day."""
    moment = datetime.fromisoformat(text)
    if len(text) <= len("2026-12-31"):
        moment += timedelta(days=1)
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=read_zone(zone))
    return moment.timestamp()


def _secret(token_file: Path, source: str, key: str) -> SecretStr:
    try:
        return SecretStr(read_secret(token_file))
    except UsageError as exc:
        raise ConfigError(source, f"{key}.token_file", str(exc)) from exc
