"""The services ``/apps/load``, ``/apps/unload`` and ``/apps/reload``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final

from homebot.devices.app_messages import ChangeAppRequest, ChangeAppResponse, LoadApp, ReloadApp, UnloadApp
from homebot.devices.names import LOAD_APP, RELOAD_APP, UNLOAD_APP
from homebot.errors import HomebotError
from homebot.graph import Node

__all__ = ["serve_change"]

_TYPES: Final = {LOAD_APP: LoadApp, UNLOAD_APP: UnloadApp, RELOAD_APP: ReloadApp}


def serve_change(node: Node, service: str, change: Callable[[str], Awaitable[str]]) -> None:
    """Serve *service*, which changes an app by its name, or says why not."""

    async def answer(request: ChangeAppRequest) -> ChangeAppResponse:
        try:
            return ChangeAppResponse(message=await change(request.app))
        except HomebotError as exc:
            return ChangeAppResponse(success=False, message=str(exc))

    node.create_service(_TYPES[service], service, answer)
