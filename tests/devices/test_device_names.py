"""Which devices a name calls: the literal meaning first, and a similar name never."""

import pytest
from tests.recorded_house import device, part

from homebot.devices.device_names import devices_called, name_query
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits

NAMES = {
    "den": "The Den",
    "lamp_1": "Lamp",
    "lamp_2": "lamp",
    "the lamp": "Old",
    "q": '"Quoted"',
    "k": "Küche",
    "a b": "Box",
}
LAMP = device("Lamp", part("light", "on_off"))
DEVICES = tuple(
    LAMP.model_copy(update={"id": device_id, "name": name, "names": (name,)}) for device_id, name in NAMES.items()
)


@pytest.mark.parametrize(
    ("text", "ids"),
    [
        ("den", ["den"]),
        ("the den", ["den"]),
        ("the Den", ["den"]),
        ("lamp", ["lamp_1", "lamp_2"]),
        ("'Lamp'", ["lamp_1", "lamp_2"]),
        ("my lamp", ["lamp_1", "lamp_2"]),
        ("the lamp", ["the lamp"]),
        ("The Lamp", ["the lamp"]),
        ('"Quoted"', ["q"]),
        ("quoted", []),
        ("kuche", ["k"]),
        ("my_lamp", []),
        ("lam", []),
        ("lamp_1", ["lamp_1"]),
        ("LAMP_1", ["lamp_1"]),
        ("a b", ["a b"]),
        ("", []),
    ],
)
def test_a_name_calls_whole_names_the_most_literal_first(text: str, ids: list[str]) -> None:
    called = devices_called(text, DEVICES)
    assert [device.id for device in called] == ids
    assert all(fits(name_query(text), facets_of(device)) for device in called)


def test_the_id_before_a_part_calls_its_device_whatever_its_case() -> None:
    assert [device.id for device in devices_called("LAMP_1#left", DEVICES, "LAMP_1")] == ["lamp_1"]
    assert [device.id for device in devices_called("lamp", DEVICES, "lamp")] == ["lamp_1", "lamp_2"]
