"""The server that identifies devices. Loaded with the first goal, or if values are left to put back."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING, final

from homebot.devices.device_lookup import DeviceLookup
from homebot.identify.identify_server import IdentifyServer
from homebot.identify.kept_values import KeptValues
from homebot.runtime.app_host import IDENTIFY_VALUES

if TYPE_CHECKING:
    from datetime import time

    from homebot.control import Control
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import CommandRequest
    from homebot.devices.outcomes import Refused
    from homebot.graph import Node
    from homebot.runtime.app_host import AppHost


@final
class IdentifyStarter:
    """Starts the server with the first goal, and puts back what a killed homebot left."""

    def __init__(self, node: Node, host: AppHost, control: Callable[[], Control | None], random: Random | None) -> None:
        self._node = node
        self._host = host
        self._control = control
        self._random = random or Random()  # noqa: S311 - no secret
        store = host.store(IDENTIFY_VALUES)
        self._kept = KeptValues(node, DeviceLookup(node), store, host.write_stores, host.began_at)
        node.create_task(self._kept.run)

    def serve(self) -> None:
        """Create the server."""

        async def tell(message: str, title: str) -> None:
            await self._host.context.notify(message, title, self._node.full_name)

        IdentifyServer(self._node, self._kept, self._preview, tell, self._quiet_hours, self._random)

    def _preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        control = self._control()
        return None if control is None else control.preview(request, device, part)  # then nothing can be held either

    def _quiet_hours(self) -> tuple[tuple[time, time], ...]:
        control = self._control()
        return () if control is None else control.quiet_hours()
