"""The safe side: commands that make the house safer, and so need neither a right nor an approval. Pure."""

from __future__ import annotations

from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.command_pattern import VERBS

__all__ = ["is_safe"]

_SAFE: Final = ("lock", "turn off")


def is_safe(command: IssuedCommand) -> bool:
    """Return whether all that is set makes the house safer: a valve that closes does, a door that closes may hurt."""
    return all(
        any(VERBS[verb](name, value, None) for verb in _SAFE)
        or value == "stopped"
        or (name, value) == ("valve", "closed")
        or (name == "alarm" and isinstance(value, str) and value.startswith("armed"))
        for name, value in command.settings.items()
    )
