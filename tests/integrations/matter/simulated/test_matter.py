"""Matter devices and tags of a simulated house, as homebot finds them."""

import anyio
import pytest
from tests.house.onlooker import found, house
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE
from tests.simulated.families import FAMILIES

from homebot.devices.tags import TagTap

pytestmark = pytest.mark.slow

pytest.importorskip("nfc")  # else pytest looks for it in the loop, when homebot asks whether it is installed


async def test_a_bridge_is_a_device_and_so_is_each_device_behind_it() -> None:
    lamp: dict[str, object] = {"kind": "lamp"}
    tables: dict[str, dict[str, object]] = {
        "lamp": lamp | {"dialect": FAMILIES["matter"]},
        "plug": lamp | {"dialect": FAMILIES["matter_plug"]},
        "bridged": lamp | {"dialect": FAMILIES["matter_bridge"]},
        "door": {"kind": "contact", "dialect": FAMILIES["matter_bridge"]},
    }
    async with alone_on_loopback(), house(tables) as (node, _):
        devices = await found(node, "Matter bridge", "lamp", "plug", "bridged", "door")
    capabilities = {
        name: {capability.name for one in device.parts for capability in one.part.capabilities}
        for name, device in devices.items()
    }
    assert capabilities["lamp"] == {"on_off", "level", "color_temperature", "locate"}
    assert capabilities["plug"] == {"on_off", "locate"}
    assert capabilities["bridged"] == capabilities["lamp"]
    assert "contact" in capabilities["door"]
    assert {devices[name].parts[0].part.service_type for name in ("lamp", "bridged")} == {"light"}
    assert devices["plug"].parts[0].part.service_type == "plug"


async def test_a_tag_of_the_house_points_to_a_lamp() -> None:
    tables: dict[str, dict[str, object]] = {
        "lamp": {"kind": "lamp", "dialect": FAMILIES["matter"]},
        "tag": {"kind": "tag", "dialect": FAMILIES["nfc"], "text": "lamp", "every": 1.0, "hold": 0.5},
    }
    async with alone_on_loopback(), house(tables) as (node, _):
        taps = node.create_subscription(TagTap, "/gateway/nfc/taps", qos_profile=10)
        with anyio.fail_after(PATIENCE):
            while (tap := await taps.receive()).device == "":
                pass
        lamp = (await found(node, "lamp"))["lamp"]
    assert (tap.device, tap.area, tap.points_to) == (lamp.id, "hall", "lamp")
