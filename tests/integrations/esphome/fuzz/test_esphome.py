"""Entities and states as no device would send them: described and read, or unknown; commands made, or refused."""

import math
from collections.abc import Callable

from aioesphomeapi import model
from aioesphomeapi.model_conversions import STATE_TYPE_TO_INFO_TYPE
from tests.fuzz.conftest import Fuzz, Mutator

from homebot.devices.part import check_setting
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.esphome.formats.device import EsphomeDevice

KINDS = {kind: info for kind, info in model.COMPONENT_TYPE_TO_INFO.items() if kind != "camera"}
STATES = {info: state for state, info in STATE_TYPE_TO_INFO_TYPE.items()}
CLASSES = ("temperature", "door", "outlet", "identify", "battery", "garage", "energy", "°F", "%", "kWh")


def fields(mutator: Mutator, cls: type) -> dict[str, object]:
    """The fields of a message: those it has by default, sensible ones, and others."""
    rng = mutator.rng
    found: dict[str, object] = cls().to_dict()
    for name, value in found.items():
        match rng.randrange(8):
            case 0:
                found[name] = mutator.value()
            case 1 | 2 if isinstance(value, bool):
                found[name] = True
            case 1 | 2 | 3 if isinstance(value, float):
                found[name] = rng.choice((0.0, 0.5, 1.0, 153.0, 500.0, 20.5, -1.0, math.nan, math.inf))
            case 1 | 2 | 3 if isinstance(value, int):
                found[name] = rng.choice((0, 1, 2, 3, 7, 11, 19, 35, 39, 47, 51, 63, 255, 511, -1))
            case 1 | 2 | 3 if isinstance(value, str):
                found[name] = mutator.word()
            case 1 | 2 | 3 if isinstance(value, list):
                choices: tuple[object, ...] = (0, 1, 2, 3, 6, 7, 11, 19, 35, 39, 47, 51, 99, mutator.word())
                found[name] = [rng.choice(choices) for _ in range(rng.choice((1, 3, 3, 700)))]
            case _:
                pass
    return found


def test_odd_entities_are_described_read_and_commanded(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("esphome", CLASSES):
        listed = [(kind, fields(mutate, KINDS[kind])) for kind in rng.choices(tuple(KINDS), k=rng.choice((1, 2, 4)))]
        device = EsphomeDevice(fields(mutate, model.DeviceInfo), listed)
        parts = {part.id: part for part in device.parts()}
        assert parts.keys() == device.entities.keys()
        for part_id, entity in device.entities.items():
            part = parts[part_id]
            state = STATES.get(KINDS[entity.component])
            for _ in range(2 if state else 0):
                assert state is not None
                for name, value in entity.read(fields(mutate, state)).items():
                    assert can_report(part, name, value), (part_id, name, value)
            for one in part.capabilities:
                tell(entity.command, one.name, mutate.plain(), rng.choice((0.0, 1.5)))
                choices: tuple[PlainValue, ...] = (*one.options, True, False, 0.0, 50.0, 100.0, 2700.0, (10.0, 20.0))
                allowed = rng.choice(choices)
                try:
                    check_setting("esp", part, one.name, allowed)
                except RefusedError:
                    continue
                tell(entity.command, one.name, allowed, 0.0)


def tell(command: Callable[..., object], name: str, value: PlainValue, transition: float) -> None:
    try:
        command(name, value, transition, "1234")
    except RefusedError:
        return


def test_a_device_with_thousands_of_entities_is_cut() -> None:
    listed: list[tuple[str, dict[str, object]]] = [
        ("sensor", {"key": number, "object_id": "x" * 1000, "name": "y" * 10_000}) for number in range(3000)
    ]
    device = EsphomeDevice({}, listed)
    assert (len(device.entities), device.left_out) == (500, 2500)
    assert all(len(part.id) < 140 and len(part.name) <= 255 for part in device.parts())
