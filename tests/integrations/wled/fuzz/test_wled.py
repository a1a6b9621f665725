"""Damaged documents of WLED: refused in our words, or understood."""

import json

from tests.fuzz.conftest import Fuzz
from tests.integrations.wled.formats.wled_documents import (
    BEFORE_0_13,
    RGB_0_15,
    RGBW_0_14,
    TWO_SEGMENTS_0_15,
    WHITES_0_13,
)

from homebot.conventions.payload import parse_object
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.wled.formats.strip import WledStrip, effect_names

TEXTS = [json.dumps(one) for one in (RGB_0_15, RGBW_0_14, TWO_SEGMENTS_0_15, WHITES_0_13, BEFORE_0_13)]
WORDS = ("seg", "seglc", "lc", "col", "cct", "bri", "on", "id", "state", "info", "leds")


def test_damaged_documents_are_refused_or_read(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("wled", WORDS):
        try:
            document = parse_object(mutate.damaged_json(rng.choice(TEXTS)))
            strip = WledStrip(document, effect_names(mutate.value()) or ("Solid", "Blink"))
        except WireError:
            continue
        parts = {one.id: one for one in strip.parts()}
        assert len(parts) == len(strip.parts())
        for part, readings in strip.readings():
            for name, value in readings.items():
                assert can_report(parts[part], name, value), (part, name, value)
        for one in (strip.name, *strip.metadata.values(), *strip.identifiers):
            assert one.isprintable()
        for part_id in [*parts, mutate.word()][:5]:
            try:
                state = strip.write(part_id, {rng.choice(("on_off", "level", "color", "effect")): mutate.plain()}, 1.0)
            except RefusedError:
                continue
            json.dumps(state, allow_nan=False).encode()
