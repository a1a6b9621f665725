"""Damaged accessories of HomeKit: refused in our words, or understood."""

import json
from contextlib import suppress

from tests.fuzz.conftest import Fuzz
from tests.gateways.checked_command import checked_command
from tests.integrations.homekit.gateway.fake_accessories import PERMS, accessory, characteristic, service

from homebot.conventions.capability_row import writer_of
from homebot.errors import PeerError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.homekit.formats.accessory import parse_accessories
from homebot.integrations.homekit.formats.parts import _TYPE_OF, parts_of
from homebot.integrations.homekit.formats.services import CLIMATE_ROWS, OPENING_ROWS, POWER_ROWS

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
