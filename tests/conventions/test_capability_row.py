from collections.abc import Callable, Mapping
from typing import TypeAlias

import pytest

from homebot.conventions.capability_row import CapabilityRow, described, writer_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

Lamp: TypeAlias = Mapping[str, float]
LampRow: TypeAlias = CapabilityRow[Lamp, Callable[[Lamp], PlainValue], Callable[[Lamp, float], Lamp]]

ROWS: tuple[LampRow, ...] = (
    CapabilityRow("level", lambda lamp: lamp["dim"], lambda _lamp, value: {"dim": value}, lambda lamp: "dim" in lamp),
    CapabilityRow("press"),
    CapabilityRow(
        "measurement", lambda lamp: lamp["w"], unit="W", bounds=lambda lamp: (0, lamp["w"]), named=lambda _: "power"
    ),
)


def test_a_source_has_the_capabilities_of_the_rows_that_apply() -> None:
    assert [one.name for one, _ in described(ROWS, {"w": 4.0})] == ["press", "power"]
    (level, _), (press, _), (power, _) = described(ROWS, {"dim": 40.0, "w": 4.0}, assumed=True)
    assert (level.readable, level.settable, level.echoed) == (True, True, True)
    assert (press.readable, press.settable) == (True, False)
    assert (power.unit, power.bounds, power.echoed) == ("W", (0, 4.0), False)


def test_a_command_goes_to_the_writer_of_its_row_and_another_is_refused_by_name() -> None:
    assert writer_of(ROWS, "level")({}, 40.0) == {"dim": 40.0}
    with pytest.raises(RefusedError, match="this part takes level"):
        writer_of(ROWS, "press")
