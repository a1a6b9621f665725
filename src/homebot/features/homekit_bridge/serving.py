"""The start of the bridges."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

from anyio import to_thread

from homebot.devices.names import LIST_SCENES
from homebot.feature import all_features, load
from homebot.support.production_loop import load_beside_loop

if TYPE_CHECKING:
    from homebot.feature_context import FeatureContext


async def serve_bridges(house: FeatureContext) -> None:
    """Serve the bridges until cancelled; the library and the server of scenes load in a thread, as that takes long."""
    bridge = await to_thread.run_sync(import_module, "homebot.features.homekit_bridge.bridge")
    for feature in all_features():
        if feature.server and any(service.name == LIST_SCENES for service in feature.services):
            await load_beside_loop(partial(load, feature.server))
    await bridge.serve(house)
