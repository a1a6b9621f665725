"""In random homes whose devices are honest no witness ever contradicts one; in virtual time."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass, field
from functools import partial

import anyio
import pytest
from hypothesis import HealthCheck, event, example, given, settings
from hypothesis import strategies as st
from tests.control.conftest import Behaviour, Home, OpenHome

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, Outcome
from homebot.testing import VirtualTimeLoop

LEARN = 14


@dataclass
class SimpleSensor:
    """A light sensor or a meter.

    Attributes:
        kind: ``illuminance`` or ``power``.
        threshold: The change that it reports, as a number and as a share of its last report.
        delay: Seconds until it reports a change.
        noise: By how much a measurement is off, at most, in turns up and down.
        repeats: Whether it tells its last report again and again.
        told: What it reported last.
        measured: How often it measured.
        waiting: What it measured and tells after its delay, in that order.
    """

    kind: str
    threshold: tuple[float, float]
    delay: float
    noise: float
    repeats: bool
    told: float = 0.0
    measured: int = 0
    waiting: deque[float] = field(default_factory=deque)

    def measure(self, value: float) -> bool:
        """Take a true value in; return whether it is worth a report."""
        self.measured += 1
        value += self.noise * ((self.measured * 7919) % 13 - 6) / 6
        absolute, share = self.threshold
        if abs(value - self.told) <= max(absolute, share * self.told, 1e-9):
            return False
        self.told = value
        return True


@dataclass
class HonestHome:
    """A room with lamps, whose sensors measure what is really so.

    Attributes:
        lamps: What each lamp gives.
        slow: Seconds that each lamp takes to obey; it reports then.
        sensors: The sensors.
        daylight: The daylight, seconds after the learning each; between them the sun rises or sets evenly.
        clouds: Shares of the daylight that come in, in turns.
        area: The room of the sensors, which nobody may have said.
    """

    lamps: list[float]
    slow: list[float]
    sensors: list[SimpleSensor]
    daylight: list[float]
    clouds: list[float]
    area: str = "Hall"
    on: dict[str, bool] = field(default_factory=dict)

    def true_value(self, kind: str, now: float) -> float:
        """What there is to measure."""
        lamps = sum(lux for number, lux in enumerate(self.lamps) if self.on.get(f"lamp{number}"))
        if kind == "power":
            return lamps
        hours = now / 300
        first = int(hours) % len(self.daylight)
        one, other = self.daylight[first], self.daylight[(first + 1) % len(self.daylight)]
        sun = one + (other - one) * (hours - int(hours))
        return lamps + sun * self.clouds[int(now / 17) % len(self.clouds)]


lamps = st.lists(st.floats(5.0, 300.0), min_size=1, max_size=3)
sensors = st.builds(
    SimpleSensor,
    kind=st.sampled_from(["illuminance", "illuminance", "power"]),
    threshold=st.tuples(st.sampled_from([0.0, 0.0, 1.0, 20.0, 80.0]), st.sampled_from([0.0, 0.0, 0.05, 0.2, 0.5])),
    delay=st.sampled_from([0.0, 0.1, 0.5, 2.0, 6.0, 15.0]),
    noise=st.sampled_from([0.0, 0.0, 0.5, 5.0, 40.0]),
    repeats=st.booleans(),
)
homes = st.builds(
    HonestHome,
    lamps=lamps,
    slow=st.lists(st.sampled_from([0.0, 0.3, 1.5]), min_size=3, max_size=3),
    sensors=st.lists(sensors, min_size=1, max_size=3),
    daylight=st.lists(st.sampled_from([0.0, 0.0, 0.0, 5.0, 30.0, 60.0, 400.0]), min_size=2, max_size=5),
    clouds=st.lists(st.floats(0.5, 1.0), min_size=1, max_size=4),
    area=st.sampled_from(["Hall", "Hall", ""]),
)
steps = st.lists(
    st.tuples(
        st.sampled_from([0.0, 0.0, 0.5, 2.0, 9.0, 30.0, 60.0, 200.0]),
        st.integers(0, 2),
        st.booleans(),
        st.sampled_from(["app", "app", "app", "hand"]),
    ),
    min_size=5,
    max_size=30,
)


def obeying(honest: HonestHome, number: int) -> Behaviour:
    """Obey after a while, and report it."""

    async def behaviour(home: Home, command: Command) -> None:
        async def act() -> None:
            await anyio.sleep(honest.slow[number])
            await switch(home, honest, command.key, is_on=command.value.plain() is True)

        home.tasks.start_soon(act)

    return behaviour


async def switch(home: Home, honest: HonestHome, lamp: str, *, is_on: bool) -> None:
    """Turn a lamp on or off, show it to the sensors, and report it."""
    honest.on[lamp] = is_on
    await look(home, honest)
    await home.report(lamp, "on_off", is_on)


async def look(home: Home, honest: HonestHome, *, again: bool = False) -> None:
    """Let the sensors measure, and report where that is worth it."""
    for number, sensor in enumerate(honest.sensors):
        is_new = sensor.measure(honest.true_value(sensor.kind, anyio.current_time()))
        if not is_new and not (again and sensor.repeats):
            continue
        if sensor.delay:
            sensor.waiting.append(sensor.told)
            home.tasks.start_soon(tell, home, sensor, f"sensor{number}")
        else:
            await home.report(f"sensor{number}", sensor.kind, sensor.told)


async def tell(home: Home, sensor: SimpleSensor, key: str) -> None:
    """Report after the delay of *sensor* what waits longest: of two timers of one time the later one may come first."""
    await anyio.sleep(sensor.delay)
    await home.report(key, sensor.kind, sensor.waiting.popleft())


async def live(home: Home, honest: HonestHome, plan: list[tuple[float, int, bool, str]]) -> list[Outcome]:
    """Switch the lamps, one after the other, until each sensor could learn, then as *plan* says."""
    for number, sensor in enumerate(honest.sensors):
        home.put(f"sensor{number}", "light_sensor", readable=(sensor.kind,), area=honest.area)
    for number in range(len(honest.lamps)):
        home.put(f"lamp{number}", "light", "on_off", area="Hall")
        home.behaviours[f"lamp{number}"] = obeying(honest, number)
        await home.report(f"lamp{number}", "on_off", False)
    found: list[Outcome] = []
    handles = [await home.handle(Light, f"lamp{number}") for number in range(len(honest.lamps))]

    async def command(number: int, is_on: bool) -> None:  # noqa: FBT001 - for a task
        lamp = handles[number]
        found.append(await (lamp.turn_on() if is_on else lamp.turn_off()))

    async def measure() -> None:
        while True:
            await look(home, honest, again=True)
            await anyio.sleep(2)

    home.tasks.start_soon(measure)
    await command(0, False)
    await anyio.sleep(60)
    for number in range(len(handles)):
        for turn in range(LEARN):
            await command(number, turn % 2 == 0)
            await anyio.sleep(31)
    async with anyio.create_task_group() as tasks:
        for gap, which, is_on, by in plan:
            number = which % len(handles)
            if by == "app":
                tasks.start_soon(command, number, is_on)
            else:
                tasks.start_soon(partial(switch, home, honest, f"lamp{number}", is_on=is_on))
            await anyio.sleep(gap)
    return found


NOISY_METER = SimpleSensor("power", (0.0, 0.05), delay=0.5, noise=0.5, repeats=False)
LUX = SimpleSensor("illuminance", (0.0, 0.0), delay=0.1, noise=0.0, repeats=False)


@example(  # the meter measures twice in the moment in which the lamp is turned on
    honest=HonestHome([9.0], [0.0, 0.0, 0.0], [LUX, NOISY_METER], [0.0, 30.0], [1.0]),
    plan=[*[(0.0, 0, False, "app")] * 4, (0.5, 0, True, "app")],
)
@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
@given(honest=homes, plan=steps)
@pytest.mark.no_cover
def test_an_honest_lamp_is_never_contradicted_by_a_witness(
    open_home: OpenHome, honest: HonestHome, plan: list[tuple[float, int, bool, str]]
) -> None:
    """Whatever the sun and the clouds do, how many lamps are switched at once, how coarse and slow the sensors are."""
    honest.on.clear()

    async def run() -> list[Outcome]:
        async with open_home(rate_limit=False) as home:
            return await live(home, honest, plan)

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        outcomes = runner.run(run())
    witnessed = sum(isinstance(one, Confirmed) and one.evidence is Evidence.WITNESSED for one in outcomes)
    event(f"witnessed: {witnessed > 0}")
    assert [one for one in outcomes if isinstance(one, Contradicted) and one.witness] == []
