"""An app looks back."""

from typing import cast

import anyio
import pytest

from homebot import App, Handle
from homebot.errors import UsageError
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


class Report(App):
    """Waits for a meter, and looks back."""

    energy_of_day: float = -1.0
    powers: tuple[float, ...] = ()
    problem: str = ""

    async def run(self) -> None:
        await anyio.sleep(3600)
        try:
            meters = await self.devices.find(Handle, name="washer")
            meter = next(one for one in meters if one.capabilities[0].name == "power")
            Report.powers = (await self.history(meter, "power", since="99999d")).values
            Report.energy_of_day = (await self.energy())[0].used
        except UsageError as exc:
            Report.problem = str(exc)


DISCOVERY = (
    '{"device": {"identifiers": ["washer"], "name": "washer"}, "name": null, "unique_id": "w_%s", '
    '"state_topic": "washer", "device_class": "%s", "unit_of_measurement": "%s", '
    '"value_template": "{{ value_json.%s }}"}'
)


@pytest.mark.parametrize("config", [{"history": {"enabled": True}}, {}])
async def test_an_app_reads_powers_and_energy(config: dict[str, object]) -> None:
    """Where none is kept, it is told how to keep one."""
    Report.energy_of_day, Report.powers, Report.problem = -1.0, (), ""
    async with virtual_house_of(f"{__name__}:Report", config=config) as house:
        assert ("/history/read" in house.runtime.graph.coming) == bool(config), "a call waits for its start"
        for name, unit in (("power", "W"), ("energy", "kWh")):
            await house.says(f"homeassistant/sensor/washer/{name}/config", DISCOVERY % (name, name, unit, name))
        await anyio.sleep(60)
        for minute in range(50):
            await house.says("washer", f'{{"power": {100.0 + minute}, "energy": {5 + minute / 10}}}')
            await anyio.sleep(60)
        await anyio.sleep(700)
    if config:
        assert {100.0, 149.0} <= {*cast("tuple[float, ...]", Report.powers)}
        assert Report.energy_of_day == pytest.approx(4.9)
    else:
        assert "no history is kept" in Report.problem
