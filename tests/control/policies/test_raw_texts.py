"""Raw texts are no way around the policies for what always asks."""

from __future__ import annotations

import pytest
from tests.control.conftest import OpenHome

from homebot.devices.handles import DoorLock, Light
from homebot.errors import RefusedError
from homebot.graph import Node

pytestmark = pytest.mark.virtual_time


async def test_a_lock_takes_no_raw_text_beside_a_runtime(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "homebot"):
        home.put("lock", "door_lock", "lock")
        lock = await home.handle(DoorLock)
        with pytest.raises(RefusedError, match="it always asks; command it by its handle"):
            await home.devices.tell(lock.device, "unlock")
        assert home.commands == []


async def test_a_lamp_takes_raw_text(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "homebot"):
        home.put("lamp", "light", "on_off")
        lamp = await home.handle(Light)
        assert await home.devices.tell(lamp.device, "on") == ()
