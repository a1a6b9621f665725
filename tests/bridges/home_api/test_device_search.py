"""The device that a text means, by its id, its part or its name."""

from collections.abc import Mapping
from typing import Any

import pytest

from homebot.bridges.home_api.device_search import meant_device
from homebot.devices import Device
from homebot.devices.services import FindDevicesResponse
from homebot.messages.builtin_interfaces import Time

NOW = Time(sec=1, nanosec=0)
LAMP = Device(
    id="Hall_Lamp",
    name="Lamp #2",
    service_type="light",
    endpoints=(),
    metadata=(),
    first_seen=NOW,
    last_seen=NOW,
    expires=NOW,
    freshness="fresh",
)


class OneLamp:
    """A house in which every question finds the lamp."""

    home = "villa"

    def now(self) -> float:
        return 0.0

    def offers(self, service: str) -> bool:
        return bool(service)

    async def call(self, service: str, request: Mapping[str, object]) -> Any:  # noqa: ARG002 - the lamp is all there is
        return FindDevicesResponse(devices=(LAMP,), sequence=0)


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ("Hall_Lamp", "Hall_Lamp"),
        ("hall_lamp", "Hall_Lamp"),
        ("Hall_Lamp#ring", "Hall_Lamp#ring"),
        ("hall_lamp#ring", "Hall_Lamp#ring"),
        ("Lamp #2", "Hall_Lamp"),
    ],
)
async def test_a_part_follows_an_id_and_a_name_may_have_a_number_sign(text: str, target: str) -> None:
    assert (await meant_device(OneLamp(), text)).target == target
