"""A Shelly of the second generation at a gateway: asked who it is, described, heard and switched."""

import json
from collections.abc import Mapping
from typing import Any

import anyio
import pytest
from tests.conventions.shelly.test_gen2_bluetooth import TRV, valve
from tests.gateways.mqtt.simple_house import simple_house

pytestmark = pytest.mark.virtual_time

ID = "shellyplus1-a8032abe54dc"
ANSWERS: dict[str, object] = {
    "Shelly.GetDeviceInfo": {"name": "Hall", "id": ID, "mac": "A8032ABE54DC", "model": "SNSW-001X16EU", "gen": 2},
    "Shelly.GetConfig": {"sys": {"device": {}}, "switch:0": {"name": "Lamp"}},
    "Shelly.GetStatus": {"sys": {"mac": "A8032ABE54DC"}, "switch:0": {"id": 0, "output": True}},
}


async def calls(house: Any, answers: Mapping[str, object] = ANSWERS) -> list[tuple[str, object]]:
    """Answer every call that came; return the methods and their parameters."""
    found = []
    for _ in range(20):
        await anyio.sleep(0.1)
        for message in await house.heard():
            frame = json.loads(message.payload)
            found.append((frame["method"], frame.get("params")))
            if frame["method"] in answers:
                answer = {"id": frame["id"], "src": ID, "dst": frame["src"], "result": answers[frame["method"]]}
                await house.say(f"{frame['src']}/rpc", answer)
    return found


async def test_it_is_asked_described_heard_and_switched() -> None:
    async with simple_house(conventions=("homebot.conventions.shelly:Shelly",)) as house:
        await house.listen(f"{ID}/rpc")
        await house.say(f"{ID}/online", "true", retain=True)
        asked = [method for method, _ in await calls(house)]
        questions = ["Shelly.GetDeviceInfo", "Shelly.GetConfig", "Shelly.GetStatus", "Shelly.GetComponents"]
        assert asked == [*questions, "Shelly.GetStatus"]

        key = f"shelly:{ID}"
        sighting = house.sighted()[-1]
        assert (sighting.key, sighting.name, sighting.service_type) == (key, "Hall", "switch")
        assert {"switch:0.on_off": True} in [readings for _, readings, _ in house.told()]

        assert (await house.command(key, "switch:0", "on_off", False)).success
        assert await calls(house) == [("Switch.Set", {"id": 0, "on": False})]

        news = {"src": ID, "method": "NotifyStatus", "params": {"switch:0": {"output": False}}}
        await house.say(f"{ID}/events/rpc", news)
        assert house.told()[-1] == (key, {"switch:0.on_off": False}, False)


async def test_the_word_that_makes_an_old_one_known_is_heard() -> None:
    """The first generation says what it is by saying how it is."""
    async with simple_house(conventions=("homebot.conventions.shelly:Shelly",)) as house:
        await house.say("shellies/shellyplug-s-6A6375/online", "true")
        await house.say("shellies/shellyplug-s-6A6375/relay/0", "on")
        assert [one.kind for one in house.sighted()][:1] == ["appeared"]
        assert any(value is True for _, readings, _ in house.told() for value in readings.values())


async def test_a_valve_behind_it_is_a_device_that_is_unreachable_with_it() -> None:
    listed = {"components": [valve(name="Bath")], "offset": 0, "total": 1}
    async with simple_house(conventions=("homebot.conventions.shelly:Shelly",)) as house:
        await house.listen(f"{ID}/rpc")
        await house.say(f"{ID}/online", "true", retain=True)
        await calls(house, {**ANSWERS, "Shelly.GetComponents": listed})
        key = f"shelly:{ID}/{TRV}"
        assert {one.key: one.name for one in house.sighted()}[key] == "Bath"
        told = [readings for device, readings, _ in house.told() if device == key]
        assert {"thermostat.heating_setpoint": 17.8}.items() <= {k: v for one in told for k, v in one.items()}.items()
        assert (await house.command(key, "thermostat", "heating_setpoint", 21.0)).success
        assert [method for method, _ in await calls(house)] == ["BluTRV.Call"]
        await house.say(f"{ID}/online", "false", retain=True)
        assert (key, {".reachable": False}, False) in house.told()
