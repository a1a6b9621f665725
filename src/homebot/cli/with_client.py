"""Runs a command that talks to a running homebot."""

from __future__ import annotations

import argparse
import os
from collections.abc import Awaitable, Callable
from pathlib import Path

import anyio

from homebot.cli.door_client import DoorClient, open_door
from homebot.errors import ConfigError

__all__ = ["with_client"]


def with_client(options: argparse.Namespace, command: Callable[[DoorClient], Awaitable[int]]) -> int:
    """Run *command* with a connection to the homebot that *options* name, and return its exit code.

    Raises:
        HomebotError: Nobody answers, the door does not let us in, or the command failed.
    """
    host, port = options.door
    token = _token(options.token_file)

    async def run() -> int:
        async with open_door(host, port, token) as door:
            return await command(door)

    return anyio.run(run)


def _token(file: str | None) -> str:
    if file is None:
        return os.environ.get("HOMEBOT_DOOR_TOKEN", "")
    try:
        return Path(file).read_text(encoding="utf-8").strip()
    except (OSError, ValueError) as exc:
        raise ConfigError("--token-file", file, f"cannot be read: {exc}") from exc
