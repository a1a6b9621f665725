"""Values of devices over days, restarts, and clocks that are set."""

from pathlib import Path
from zoneinfo import ZoneInfo

import anyio
import pytest
from anyio import to_thread
from tests.features.history.conftest import MIDNIGHT, MakeHouse

from homebot.devices.query.term_messages import query_terms, query_words
from homebot.features.history.history_file import HistoryFile
from homebot.features.history.settings import KeepSettings
from homebot.support.sqlite_file import SqliteFile
from homebot.words.queries import parse_query

pytestmark = pytest.mark.virtual_time

HOUR = 3600.0
DAY = 24 * HOUR


async def test_a_value_is_read_before_it_is_written(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.report("thermometer", temperature=21.5)
        series = await house.read("thermometer")
    assert (series.values, series.unit, series.width, series.name) == ((21.5,), "°C", 0.0, "Thermometer")


@pytest.mark.parametrize(
    ("kind", "capability"), [("temperature_sensor", "temperature"), ("electrical_meter", "energy")]
)
async def test_the_first_number_of_a_new_device_is_kept_once(kept: MakeHouse, kind: str, capability: str) -> None:
    async with kept() as house:
        await house.add("new", kind, **{capability: 21.5})
        series = await house.read("new")
    assert series.values == (21.5,)


async def test_a_query_that_names_a_value_reads_that_one_as_terms_and_in_words(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.add("new", "plug", power=3.5, energy=1.5)
        for query in (query_terms(parse_query("plug with energy")), query_words("plug with energy")):
            series = await house.query(query)
            assert [one.capability for one in series] == ["energy"]


async def test_the_power_of_a_plug_is_read_first(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.add("new", "plug", on_off=True, current=0.1, power=3.5, energy=1.5)
        series = await house.query(query_terms(parse_query("plug")))
    assert [one.capability for one in series] == ["power", "current", "energy", "on_off"]


async def test_numbers_are_values_then_five_minutes_then_hours(kept: MakeHouse) -> None:
    async with kept() as house:
        for hour in range(30):
            await house.report("thermometer", temperature=20.0 + hour / 10)
            await anyio.sleep(HOUR)
        single = await house.read("thermometer", since=2 * HOUR)
        week = await house.read("thermometer", since=7 * DAY, points=4000)
        year = await house.read("thermometer", since=365 * DAY)
    assert (single.width, single.values[-1]) == (0.0, 22.9)
    assert week.width == 300.0
    assert len(week.times) == pytest.approx(30 * 12, abs=2)
    assert year.width == 18 * HOUR  # 500 points
    assert (min(year.lows), max(year.highs)) == (20.0, 22.9)


async def test_a_pause_of_a_device_is_a_gap_and_not_zero(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.report("thermometer", temperature=21.0)
        await anyio.sleep(HOUR)
        await house.report("thermometer", temperature=None)
        await anyio.sleep(2 * HOUR)
        await house.report("thermometer", temperature=22.0)
        await anyio.sleep(HOUR)
        series = await house.read("thermometer", since=6 * HOUR, points=5000)
    pauses = [after - before for before, after in zip(series.times, series.times[1:], strict=False)]
    assert max(pauses) == pytest.approx(2 * HOUR, abs=300)
    assert set(series.values) == {21.0, 22.0}


async def test_flags_are_kept_where_they_change_with_their_ends(kept: MakeHouse) -> None:
    async with kept() as house:
        for on in (True, False, True):
            await house.report("lamp", on_off=on)
            await anyio.sleep(HOUR)
        series = await house.read("lamp")
    assert series.words == ("true", "false", "true")
    assert [end - at for at, end in zip(series.times, series.ends, strict=True)] == pytest.approx([HOUR] * 3, abs=1)


async def test_each_press_is_kept_with_its_time_alone(kept: MakeHouse) -> None:
    async with kept() as house:
        for press in ("single", "single", "hold"):
            await house.report("button", press=press)
            await anyio.sleep(60)
    async with kept(MIDNIGHT + HOUR) as house:
        await house.report("button", press="double")
        series = await house.read("button")
        assert (await house.response("button", since=HOUR / 2)).series[0].words == ("double",)  # the last one is over
    assert series.words == ("single", "single", "hold", "double")
    assert series.times == series.ends
    assert [at - MIDNIGHT for at in series.times] == pytest.approx([2, 62, 122, HOUR + 2], abs=1)


async def test_a_restart_keeps_all_and_counts_the_energy_of_the_time_between(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.report("meter", energy=100.0)
        await house.report("lamp", on_off=True)
        await anyio.sleep(10)
        await house.report("meter", energy=101.0)
    async with kept(MIDNIGHT + 5 * HOUR) as house:
        await house.report("meter", energy=104.0)
        series = await house.read("lamp")
        assert [(day.day, day.used) for day in await house.energy()] == [("2026-01-01", 4.0)]
    assert series.words == ("true",)
    assert series.ends[0] - MIDNIGHT < 60


async def test_a_fall_of_a_counter_to_near_zero_is_a_reset(kept: MakeHouse) -> None:
    async with kept() as house:
        for energy in (10.0, 12.0, 0.5, 1.5):
            await house.report("meter", energy=energy)
            await anyio.sleep(HOUR)
        assert [day.used for day in await house.energy()] == [3.5]


@pytest.mark.parametrize(("begin", "hours"), [("2026-03-29", 23), ("2026-10-25", 25), ("2026-06-01", 24)])
async def test_a_day_of_the_home_has_23_to_25_hours(kept: MakeHouse, begin: str, hours: int) -> None:
    """A meter counts 1 kWh an hour; sealed days and the present one are counted alike."""
    from datetime import datetime  # noqa: PLC0415

    zone = ZoneInfo("Europe/Vienna")
    midnight = datetime.fromisoformat(begin).replace(tzinfo=zone).timestamp()
    async with kept(midnight - DAY / 2, zone) as house:
        for energy in range(72):
            await house.report("meter", energy=float(energy))
            await anyio.sleep(HOUR)
        used = {day.day: day.used for day in await house.energy(4 * DAY)}
    assert used[begin] == pytest.approx(hours, abs=0.01)


async def test_energy_is_summed_by_hour_and_month_of_devices_rooms_and_all(kept: MakeHouse) -> None:
    async with kept(MIDNIGHT + 22 * HOUR) as house:
        await house.add("oven", "electrical_meter", energy=0.0)
        for energy in range(4):
            await house.report("meter", energy=float(energy))
            await house.report("oven", energy=2.0 * energy)
            await anyio.sleep(HOUR)
        hours = [(row.day, row.used) for row in await house.energy(DAY, "hour", "all")]
        assert [(row.day, row.device, row.used) for row in await house.energy(DAY, "month")] == [
            ("2026-01", "meter", 3.0),
            ("2026-01", "oven", 6.0),
        ]
        assert [(row.device, row.name, row.used) for row in await house.energy(DAY, "month", "room")] == [("", "", 9.0)]
    assert hours == [
        ("2026-01-01T23+00:00", 3.0),
        ("2026-01-02T00+00:00", 3.0),
        ("2026-01-02T01+00:00", 3.0),
    ]


async def test_a_clock_that_is_set_back_an_hour_loses_and_doubles_nothing(kept: MakeHouse) -> None:
    async with kept() as house:
        for minute in range(190):
            if minute == 125:
                house.clock.wall -= HOUR
            await house.report("meter", power=float(minute), energy=minute / 10)
            await anyio.sleep(60)
        power = await house.read("meter", "power", since=HOUR * 2 + 660, points=5000)
        assert set(range(1, 190)) <= {round(one) for one in power.values}
        assert power.times == tuple(sorted(power.times))
        assert [day.used for day in await house.energy()] == [pytest.approx(18.9)]


async def test_a_suspended_computer_leaves_a_gap(kept: MakeHouse) -> None:
    async with kept() as house:
        await house.report("thermometer", temperature=21.0)
        await house.report("lamp", on_off=True)
        await anyio.sleep(HOUR / 2)
        house.clock.wall += 8 * HOUR
        await anyio.sleep(HOUR / 4)
        lamp = await house.read("lamp")
        number = await house.read("thermometer", points=5000)
    assert lamp.words == ("true", "true")
    assert lamp.times[1] - lamp.ends[0] == pytest.approx(8 * HOUR, abs=120)
    assert max(b - a for a, b in zip(number.times, number.times[1:], strict=False)) == pytest.approx(8 * HOUR, abs=600)


async def test_a_copy_of_the_file_has_the_values_of_this_moment(kept: MakeHouse, tmp_path: Path) -> None:
    async with kept() as house:
        await house.report("thermometer", temperature=21.5)
        (file,) = SqliteFile.opened_in(tmp_path).values()
        assert file.write_rest is not None
        await file.write_rest()
        await to_thread.run_sync(file.copy_into, tmp_path / "copy.sqlite")
    copy = HistoryFile(tmp_path / "copy.sqlite", KeepSettings())
    await to_thread.run_sync(copy.open, 0.0)
    assert (await to_thread.run_sync(copy.load)).series.keys() == {("thermometer", "", "temperature")}
    copy.close()
