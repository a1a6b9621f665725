"""The start of the bridges."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from anyio import to_thread

if TYPE_CHECKING:
    from homebot.feature_context import FeatureContext


async def serve_bridges(house: FeatureContext) -> None:
    """Serve the bridges until cancelled; the library is loaded in a thread, as that takes long."""
    await (await to_thread.run_sync(import_module, "homebot.features.homekit_bridge.bridge")).serve(house)
