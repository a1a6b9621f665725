"""Messages of a Matter server, read and written. Pure.

A server greets with its version, answers each command with its ``message_id``, and sends events of its own.

Source: python-matter-server 8.1, ``docs/websockets_api.md`` and ``common/models.py`` (schema version 11); the server of
matter.js follows the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from homebot.conventions.payload import as_fields, clean_text, compact_json, shown
from homebot.errors import LinkError, RefusedError, WireError

__all__ = [
    "MAX_FRAME_BYTES",
    "MatterEvent",
    "ServerAnswer",
    "ServerFrame",
    "ServerInfo",
    "check_result",
    "command_frame",
    "error_of",
    "read_frame",
]

MAX_FRAME_BYTES: Final = 32 * 1024 * 1024
"""Longest frame: the answer to ``start_listening`` has every attribute of every node, some 50 kB for each node."""

SCHEMA: Final = 11
"""The newest version that this module follows."""

OLDEST_SCHEMA: Final = 5

_NODE_NOT_READY, _NODE_NOT_RESOLVING, _SDK_STACK = 3, 4, 7
_TIMEOUTS = ("0x00000032", "timeout", "timed out")
"""Texts in the details of an error when the device did not answer, for which there is no error code."""


@dataclass(frozen=True, slots=True)
class ServerInfo:
    """The greeting of a server, about itself.

    Attributes:
        oldest_schema_version: The oldest that it still follows.
        fabric: The compressed ID of its fabric, 16 digits; empty if it is not stated.
    """

    schema_version: int
    oldest_schema_version: int
    has_bluetooth: bool = False
    fabric: str = ""

    def check(self) -> None:
        """Check that homebot understands its messages."""
        if self.schema_version < OLDEST_SCHEMA:
            raise WireError(
                f"the Matter server uses schema version {self.schema_version}; homebot needs {OLDEST_SCHEMA} or later"
            )
        if self.oldest_schema_version > SCHEMA:
            raise WireError(
                f"the Matter server needs schema version {self.oldest_schema_version} or later; homebot knows {SCHEMA}"
            )


@dataclass(frozen=True, slots=True)
class ServerAnswer:
    """The answer to a command: a result, or the code and the details of an error."""

    message_id: str
    result: object = None
    error_code: int | None = None
    details: str = ""


@dataclass(frozen=True, slots=True)
class MatterEvent:
    """An event, such as ``attribute_updated``, which the server sends by itself."""

    event: str
    data: object


ServerFrame: TypeAlias = ServerInfo | ServerAnswer | MatterEvent


def read_frame(fields: object) -> ServerFrame:
    """Return the message in the JSON value that a server sent; raise WireError if it is none."""
    if not isinstance(fields, dict):
        raise WireError(f"{shown(fields)} is not an object")
    if "event" in fields:
        if not isinstance(fields["event"], str):
            raise WireError(f"event is {shown(fields['event'])}, not a text")
        return MatterEvent(fields["event"], fields.get("data"))
    if "message_id" in fields:
        return _answer(fields)
    if "schema_version" in fields:
        oldest, fabric = fields.get("min_supported_schema_version", 0), fields.get("compressed_fabric_id")
        return ServerInfo(
            _whole("schema_version", fields["schema_version"]),
            _whole("min_supported_schema_version", oldest),
            fields.get("bluetooth_enabled") is True,
            f"{fabric:016X}" if type(fabric) is int and 0 < fabric < 1 << 64 else "",
        )
    raise WireError("a message is neither an event, nor an answer, nor the server's greeting")


def command_frame(message_id: str, command: str, args: Mapping[str, object]) -> str:
    """Return the message that carries a command."""
    return compact_json({"message_id": message_id, "command": command, "args": dict(args)})


def error_of(what: str, answer: ServerAnswer, *, is_secret: bool = False) -> LinkError | RefusedError:
    """Return the error that an *answer* with an error code stands for.

    Args:
        is_secret: Whether the command had a code in it; the details, which may repeat it, are not shown then.
    """
    details = "" if is_secret else clean_text(answer.details)
    reason = details or f"the Matter server answered with error {answer.error_code}"
    is_timeout = any(one in answer.details.casefold() for one in _TIMEOUTS)
    if answer.error_code in {_NODE_NOT_READY, _NODE_NOT_RESOLVING, _SDK_STACK} or is_timeout:
        return LinkError(f"{what}: {reason}")
    return RefusedError(what, reason, answer.error_code)


def check_result(what: str, result: object) -> None:
    """Raise RefusedError if the *result* of a command has a status of failure, as writes and operations may."""
    for one in result if isinstance(result, list) else ():
        status = one.get("Status") if isinstance(one, dict) else None
        if isinstance(status, int) and status != 0:
            raise RefusedError(what, f"the device answered with the status 0x{status:02x}", status)
    fields = as_fields(result)
    operation = as_fields(fields.get("commandResponseState"))
    for status in (fields.get("status"), operation.get("errorStateID", operation.get("errorStateId"))):
        if type(status) is int and status != 0:
            raise RefusedError(what, f"the device answered with the status 0x{status:02x}", status)


def _answer(fields: Mapping[str, object]) -> ServerAnswer:
    message_id = fields["message_id"]
    if not isinstance(message_id, str):
        raise WireError(f"message_id is {shown(message_id)}, not a text")
    if "error_code" not in fields:
        return ServerAnswer(message_id, fields.get("result"))
    details = fields.get("details")
    return ServerAnswer(
        message_id,
        error_code=_whole("error_code", fields["error_code"]),
        details=details[:2_000] if isinstance(details, str) else "",
    )


def _whole(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 32:
        raise WireError(f"{name} is {shown(value)}, not a number from 0 to 4294967295")
    return value
