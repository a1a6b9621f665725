"""Damaged accessories of HomeKit and resources of Hue bridges: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz
from tests.gateways.checked_command import checked_command
from tests.integrations.homekit.gateway.fake_accessories import PERMS, accessory, characteristic, service

from homebot.conventions.capability_row import writer_of
from homebot.errors import PeerError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.homekit.formats.accessory import parse_accessories
from homebot.integrations.homekit.formats.climate import CLIMATE_ROWS
from homebot.integrations.homekit.formats.lights_and_power import POWER_ROWS
from homebot.integrations.homekit.formats.openings import OPENING_ROWS
from homebot.integrations.homekit.formats.parts import _TYPE_OF, parts_of
from homebot.integrations.hue.formats.devices import devices_of
from homebot.integrations.hue.formats.resources import HueResources
from homebot.integrations.hue.formats.service_rows import press_of
from homebot.integrations.hue.simulated.resources import device_resources, group_resources, scene_resource

ROWS = (*CLIMATE_ROWS, *OPENING_ROWS, *POWER_ROWS)
SERVICES = sorted(_TYPE_OF)
TARGETS = {"137", "1B300BC2-CFFC-47FF-89F9-BD6CCF5F2853", "7B", "7D"}  # set, but not watched
KINDS = sorted({*TARGETS, *(str(one) for row in ROWS for one in row.watched)})
LIMITS = ("minValue", "maxValue", "minStep", "valid-values")


def test_damaged_accessories_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("homekit accessories", KINDS):
        limits = {name: damage.value(1) for name in LIMITS if rng.random() < 0.2}
        chosen = enumerate(rng.sample(KINDS, 8), 20)
        known = [characteristic(at, kind, damage.scalar(), PERMS, **limits) for at, kind in chosen]
        listed = damage.damaged([accessory(1, "x", service(8, rng.choice(SERVICES), *known))])
        with suppress(WireError):
            for part in (part for one in parse_accessories(listed).values() for part in parts_of(one)):
                for one in part.part.capabilities:
                    read = part.rows[one.name].read
                    assert read is not None
                    value = read(part.service)
                    assert not one.readable or can_report(part.part, one.name, value), (one.name, value)
                    with suppress(PeerError):
                        wanted = rng.choice((damage.plain(), *one.options))
                        command = checked_command(part.part, one.name, wanted)
                        for kind, number in writer_of(part.rows.values(), one.name)(part.service, command).items():
                            if kind in part.service.characteristics:
                                json.dumps(part.service.characteristics[kind].encode(number), allow_nan=False)


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
