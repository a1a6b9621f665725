import json

import pytest

from homebot.testing import VirtualHouse

BUTTON = {
    "unique_id": "bell",
    "state_topic": "bell",
    "event_types": ["single"],
    "device": {"identifiers": ["bell"], "name": "Doorbell"},
}


@pytest.mark.house("doorbell:Doorbell")
async def test_each_ring_is_told_and_counted_over_a_restart(house: VirtualHouse) -> None:
    await house.says("homeassistant/event/bell/config", json.dumps(BUTTON))  # the simulated house has no buttons
    for _ in range(2):
        await house.run_for("1s")
        await house.says("bell", '{"event_type": "single"}')
        await house.run_for("1s")
        await house.reload("doorbell")
    assert [one.message for one in house.notifications] == ["Doorbell rang, 1 so far", "Doorbell rang, 2 so far"]
