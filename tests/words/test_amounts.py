"""One meaning for a number with its unit, whoever reads it."""

import pytest

from homebot.devices.part import Capability, Part
from homebot.devices.query.terms import StateIs
from homebot.words.commands import parse_command_words
from homebot.words.queries import parse_query
from homebot.words.steps import Do, read_step

ABLE = tuple(Capability(name=name, settable=True) for name in ("level", "heating_setpoint", "color_temperature"))


@pytest.mark.parametrize(
    ("capability", "text", "number"),
    [
        ("level", "40 %", 40.0),
        ("level", "40 percent", 40.0),
        ("heating_setpoint", "21.5 °C", 21.5),
        ("heating_setpoint", "21.5 degrees", 21.5),
        ("color_temperature", "2700 K", 2700.0),
    ],
)
def test_a_unit_is_the_same_for_all(capability: str, text: str, number: float) -> None:
    part = Part(id="part", service_type="light", capabilities=tuple(one for one in ABLE if one.name == capability))
    assert parse_query(f"{capability} = {text}") == StateIs(capability, "=", number)
    assert read_step(f"thing {text}") == Do(f"thing {text}", "thing", text)
    assert parse_command_words(text, (), part, "thing") == {capability: number}
