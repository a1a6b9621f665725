"""The id of this installation of homebot, which tells it from others on the network."""

from __future__ import annotations

import hashlib
import platform
from pathlib import Path

__all__ = ["installation_id"]


def installation_id(name: str) -> str:
    """Return the id, 16 hexadecimal digits; reads a file. It stays the same, and says nothing about the computer.

    Args:
        name: The name of what is identified on this computer.
    """
    try:
        machine = Path("/etc/machine-id").read_text(encoding="ascii")
    except (OSError, ValueError):
        machine = platform.node()
    return hashlib.sha256(f"homebot {machine.strip()} {name}".encode()).hexdigest()[:16]
