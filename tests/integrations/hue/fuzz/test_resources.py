"""Damaged resources of Hue bridges: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz
from tests.gateways.checked_command import checked_command
from tests.integrations.hue.simulated.resources import device_resources, group_resources, scene_resource

from homebot.errors import PeerError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.hue.formats.devices import devices_of
from homebot.integrations.hue.formats.resources import HueResources
from homebot.integrations.hue.formats.service_rows import press_of


def test_damaged_resources_are_refused_or_read(fuzz: Fuzz) -> None:
    device, state = SimulatedDeviceInfo("home", "lamp", "x", "x", "hall"), DeviceState(text="on", value=5.0)
    kinds = ("lamp", "plug", "gradient", "motion", "lux", "contact")
    listed = [one for kind in kinds for one in device_resources(device, kind, state)]
    listed += [*group_resources("room", "Hall", [(str(listed[0]["id"]), "device")], "")]
    listed.append(scene_resource("Hall", "x", [], 1.0))

    for damage, rng in fuzz("hue resources"):
        resources = HueResources()
        with suppress(WireError):
            resources.replace([damage.damaged(one) if rng.random() < 0.3 else one for one in listed])
            change = damage.damaged(rng.choice(listed))
            press_of(change if isinstance(change, dict) else {})
            resources.change(rng.choice(("add", "update", "delete")), change)
            for one in (one for device in devices_of(resources, sorted(resources.ids)) for one in device.services):
                for row, capability in zip(one.rows, one.part.capabilities, strict=True):
                    value = None if row.read is None else row.read(resources.get(one.id))
                    assert not capability.readable or can_report(one.part, row.capability, value), (row, value)
                    with suppress(PeerError):
                        command = checked_command(
                            one.part, row.capability, damage.plain(), transition=rng.choice((0.0, 1e9))
                        )
                        json.dumps(row.write and row.write(resources.get(one.id), command), allow_nan=False)
