"""How long tests wait for sockets, threads and other programs."""

from typing import Final

PATIENCE: Final = 60.0
"""Seconds for what mostly takes milliseconds: only what is broken takes as long, on however slow or busy a machine."""
