"""Frames of the remote procedure calls that Shelly's second generation answers. Pure.

Source: Shelly Gen2+ API, General, RPC Protocol and RPC Channels (MQTT).
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from homebot.conventions.description import Publication

__all__ = ["call"]


def call(prefix: str, source: str, method: str, params: Mapping[str, object] | None = None) -> Publication:
    """Return the call of *method* of the device at *prefix*; it answers on ``<source>/rpc``."""
    frame: dict[str, object] = {"id": 1, "src": source, "method": method}
    if params is not None:
        frame["params"] = params
    return Publication(f"{prefix}/rpc", json.dumps(frame, separators=(",", ":"), ensure_ascii=False).encode())
