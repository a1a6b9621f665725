"""Checks of parts against the answers of Home Assistant to the same messages, which were recorded."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

import pytest

from homebot.conventions.description import DescribedPart
from homebot.devices.value import PlainValue


def same(ours: PlainValue, theirs: PlainValue | list[float]) -> bool:
    """Home Assistant shows whole percents, 255 steps and rounded hues."""
    if isinstance(ours, tuple) and isinstance(theirs, list):
        return ours == pytest.approx(theirs, abs=1)
    return ours == (theirs if isinstance(theirs, bool | str | None) else pytest.approx(theirs, abs=0.6, rel=0.01))


def check_messages(parts: Mapping[str, DescribedPart], says: Iterable[tuple[str, str, dict[str, Any]]]) -> None:
    """After each message, by topic and payload, these values are known, by part and capability."""
    known: dict[str, dict[str, PlainValue]] = {part_id: {} for part_id in parts}
    for topic, payload, expected in says:
        for part_id, part in parts.items():
            known[part_id].update(part.codec.read(topic, payload.encode(), retained=False))
        wrong = [
            (part_id, capability, known[part_id].get(capability), value)
            for part_id, values in expected.items()
            for capability, value in values.items()
            if not same(known[part_id].get(capability), value)
        ]
        assert wrong == []


def check_commands(parts: Mapping[str, DescribedPart], orders: Iterable[tuple[str, str, Any, float, str, Any]]) -> None:
    """A part, capability, value and transition give a topic and a payload: a text, or what one in JSON spells."""
    for part_id, capability, value, transition, topic, payload in orders:
        plain = tuple(value) if isinstance(value, list) else value
        (publication,) = parts[part_id].codec.write(capability, plain, transition=transition)
        text = publication.payload.decode()
        assert (publication.topic, text if isinstance(payload, str) else json.loads(text)) == (topic, payload)
        assert topic in parts[part_id].part.writes
        assert not publication.retain
    for part in parts.values():
        if part.part.service_type == "light" and any(one.name == "level" for one in part.part.capabilities):
            assert part.part.fades == (
                part.codec.write("level", 50.0, transition=2.0) != part.codec.write("level", 50.0)
            )
        assert part.part.service_type == "light" or not part.part.fades
