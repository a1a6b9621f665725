"""Jobs of apps: called once when they are due, however the clock is set, slept through or changed over summer time."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import datetime, timedelta
from zoneinfo import ZoneInfo

import anyio
import pytest
from structlog.testing import capture_logs
from tests.set_clock import SetClock

from homebot.apps import App, AppContext, NoSettings
from homebot.apps.store import Store
from homebot.clock import read_zone
from homebot.devices.current_trigger import current_trigger
from homebot.errors import UsageError
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time

PLACES = {
    "Europe/Berlin": (52.52, 13.405),
    "America/Los_Angeles": (34.05, -118.25),
    "Europe/Oslo": (69.65, 18.96),  # Tromsø
    "Asia/Kolkata": (28.6, 77.2),
}
ZONES = {name: read_zone(name) for name in PLACES}  # read before any loop runs
HOUR, DAY = 3600.0, 86_400.0


class Diary(App):
    """Notes when its jobs are called."""

    def __init__(self, node: Node, setup: Callable[[Diary], object]) -> None:
        super().__init__(node, NoSettings())
        self.setup = setup
        self.calls: list[str] = []
        self.causes: list[str] = []

    async def run(self) -> None:
        self.setup(self)
        await anyio.sleep_forever()

    def note(self) -> None:
        self.calls.append(f"{self.now():%m-%d %H:%M:%S}")
        self.causes.append(current_trigger().text)

    def say(self, word: str) -> None:
        self.calls.append(word)

    def fail(self) -> None:
        self.note()
        raise ValueError("odd")

    async def work(self) -> None:
        self.note()
        await anyio.sleep(1.5 * HOUR)


@asynccontextmanager
async def living(
    setup: Callable[[Diary], object],
    start: str,
    zone: str = "Europe/Berlin",
    clock: SetClock | None = None,
    store: Store | None = None,
) -> AsyncIterator[tuple[Diary, SetClock]]:
    at = datetime.fromisoformat(start).replace(tzinfo=ZONES[zone])
    clock = clock or SetClock(at.timestamp())
    kept = Store("diary") if store is None else store
    async with Node(Graph(clock), "diary") as node, anyio.create_task_group() as tasks:
        diary = Diary(node, setup)
        home = AppContext(zone, *PLACES[zone], store_of=lambda _: kept, keeps_values=lambda: True)
        diary.context = replace(home, asleep=lambda: clock.slept)
        await tasks.start(diary.serve)
        await anyio.sleep(0.01)
        yield diary, clock
        tasks.cancel_scope.cancel()


async def test_a_time_that_does_not_exist_is_the_end_of_the_gap() -> None:
    async with living(lambda app: app.daily("02:30", app.note), "2026-03-28 12:00") as (diary, _):
        await anyio.sleep(3 * DAY)
    assert diary.calls == ["03-29 03:00:00", "03-30 02:30:00", "03-31 02:30:00"]


async def test_of_a_time_that_exists_twice_the_first_counts() -> None:
    async with living(lambda app: app.daily("02:30", app.note, name="n"), "2026-10-24 12:00") as (diary, _):
        await anyio.sleep(14.75 * HOUR)
        assert diary.now().isoformat() == "2026-10-25T02:45:00.010000+02:00"
        (job,) = diary.jobs
        assert job.next == datetime(2026, 10, 26, 2, 30, tzinfo=ZoneInfo("Europe/Berlin"))
        await anyio.sleep(2 * HOUR)
    assert diary.calls == ["10-25 02:30:00"]


@pytest.mark.parametrize(("start", "hours"), [("2026-03-28 22:00", 23), ("2026-10-24 22:00", 25)])
async def test_a_daily_job_over_the_change_is_at_its_local_time(start: str, hours: int) -> None:
    async with living(lambda app: app.daily("22:00", app.note), start) as (diary, _):
        await anyio.sleep(hours * HOUR - 1)
        assert diary.calls == []
        await anyio.sleep(2)
    assert [call[6:] for call in diary.calls] == ["22:00:00"]


@pytest.mark.parametrize("start", ["2026-03-28 20:00", "2026-10-24 20:00"])
async def test_an_hourly_job_over_the_change_is_each_3600_seconds(start: str) -> None:
    async with living(lambda app: app.every("1h", app.note), start) as (diary, _):
        await anyio.sleep(12 * HOUR + 60)
    assert len(diary.calls) == 12


async def test_a_clock_that_is_set_back_calls_nothing_again() -> None:
    async with living(lambda app: app.daily("22:00", app.note), "2026-06-01 21:00") as (diary, clock):
        await anyio.sleep(1.5 * HOUR)
        clock.wall -= HOUR
        await anyio.sleep(3 * HOUR)
        assert diary.calls == ["06-01 22:00:00"]
        await anyio.sleep(DAY)
    assert diary.calls == ["06-01 22:00:00", "06-02 22:00:00"]


async def test_a_clock_that_was_years_ahead_goes_on_from_where_it_is_set_back_to() -> None:
    async with living(lambda app: app.daily("22:00", app.note), "2026-06-01 21:00") as (diary, clock):
        clock.wall += 1000 * DAY
        await anyio.sleep(2 * HOUR)
        clock.wall -= 1000 * DAY
        await anyio.sleep(DAY)
    assert diary.calls[-1] == "06-02 22:00:00"
    assert len(diary.calls) == 2


@pytest.mark.parametrize("ahead", [HOUR, DAY, DAY + HOUR, 2 * DAY])
async def test_a_clock_that_is_ahead_for_two_minutes_skips_no_job_of_the_evening(ahead: float) -> None:
    async with living(lambda app: app.daily("22:00", app.note), "2026-06-01 12:00") as (diary, clock):
        await anyio.sleep(HOUR)
        clock.wall += ahead
        await anyio.sleep(120)
        clock.wall -= ahead
        await anyio.sleep(12 * HOUR)
    assert "06-01 22:00:00" in diary.calls


@pytest.mark.parametrize(
    ("catch_up", "step", "expected"),
    [("30m", 900.0, 1), ("30m", 3 * HOUR, 0), ("0s", 3 * HOUR, 0), ("0s", 20.0, 1), ("12h", 8 * HOUR, 1)],
)
async def test_a_clock_that_is_set_forward_over_a_job_goes_by_catch_up(
    catch_up: str, step: float, expected: int
) -> None:
    """As a computer that slept; a call that is a minute late at most is in time."""
    with capture_logs() as lines:
        async with living(lambda app: app.daily("22:00", app.note, catch_up=catch_up), "2026-06-01 21:59:50") as (
            diary,
            clock,
        ):
            clock.wall += step
            await anyio.sleep(120)
    assert len(diary.calls) == expected
    assert sum("is skipped: it was due" in line["message"] for line in lines) == 1 - expected
    assert all("late" in cause for cause in diary.causes) == (step > 60)


async def test_hours_that_a_computer_slept_are_at_most_one_call_of_an_hourly_job() -> None:
    """Its monotonic clock stands still meanwhile. One comes within a minute, the next on the old grid."""
    async with living(lambda app: app.every("1h", app.note), "2026-06-01 12:00") as (diary, clock):
        await anyio.sleep(1.5 * HOUR)
        clock.slept += 8 * HOUR
        clock.wall += 8 * HOUR
        await anyio.sleep(1.5 * HOUR + 1)
    assert [call[6:11] for call in diary.calls] == ["13:00", "21:31", "22:00", "23:00"]


@pytest.mark.parametrize(("catch_up", "expected"), [("0s", []), ("3h", ["06-01 23:00:00"])])
async def test_a_daily_job_that_was_missed_while_homebot_was_stopped_goes_by_catch_up(
    catch_up: str, expected: list[str]
) -> None:
    store = Store("diary")

    def setup(app: Diary) -> None:
        app.daily("22:00", app.note, catch_up=catch_up, name="evening")

    async with living(setup, "2026-06-01 23:00", store=Store("diary")) as (diary, _):
        assert diary.calls == []  # the first start ever misses nothing
    async with living(setup, "2026-06-01 20:00", store=store) as (diary, clock):
        assert diary.calls == []
    clock.wall += 3 * HOUR - clock.now() % HOUR
    async with living(setup, "2026-06-01 23:00", store=store) as (diary, _):
        await anyio.sleep(1)
        assert diary.calls == expected
    async with living(setup, "2026-06-01 23:30", store=store) as (diary, _):
        assert diary.calls == []


async def test_an_event_after_a_restart_replaces_a_durable_timer() -> None:
    """Else the lamp goes off seconds after the last motion."""
    store = Store("diary")

    def moved(app: Diary) -> None:
        app.after("1h", app.note, name="off", durable=True)

    def later(app: Diary) -> None:
        app.daily("12:59", lambda: moved(app))

    async with living(moved, "2026-06-01 12:00", store=store):
        pass
    async with living(later, "2026-06-01 12:30", store=store) as (diary, _):
        await anyio.sleep(2 * HOUR)
    assert [call[:11] for call in diary.calls] == ["06-01 13:59"]


async def test_a_durable_timer_keeps_its_arguments_and_is_dropped_if_its_method_takes_others_now() -> None:
    store = Store("diary")

    def setup(app: Diary) -> None:
        app.after("1h", app.say, args=("kept",), name="said", durable=True)

    async with living(setup, "2026-06-01 12:00", store=store):
        pass
    async with living(lambda _: None, "2026-06-01 12:30", store=store) as (diary, _):
        await anyio.sleep(HOUR)
        assert diary.calls == ["kept"]
        setup(diary)
    store["_timers"] = {"said": {**store["_timers"]["said"], "handler": "note"}}
    with capture_logs() as lines:
        async with living(lambda _: None, "2026-06-01 13:00", store=store) as (diary, _):
            assert diary.jobs == ()
    assert "the job said is skipped: handler: note is called with kept: too many" in str(lines)
    assert store["_timers"] == {}


@pytest.mark.parametrize("is_durable", [True, False])
async def test_a_timer_replaces_a_waiting_one_of_its_name(*, is_durable: bool) -> None:
    store = Store("diary")

    def setup(app: Diary) -> None:
        app.after("1h", app.note, name="off", durable=True)

    async with living(setup, "2026-06-01 12:00", store=store) as (diary, _):
        await anyio.sleep(0.5 * HOUR)
        diary.after("1h", diary.note, name="off", durable=is_durable)
        await anyio.sleep(0.75 * HOUR)
        assert diary.calls == []
        assert len(diary.jobs) == 1
    async with living(lambda _: None, "2026-06-01 12:00", store=store) as (diary, _):  # it is 13:15: time has passed
        assert [one.text for one in diary.jobs] == ["after 1h"] * is_durable
        await anyio.sleep(HOUR)
        assert [call[:11] for call in diary.calls] == ["06-01 13:30"] * is_durable


async def test_jobs_wait_for_a_clock_that_was_not_set_yet() -> None:
    def setup(app: Diary) -> None:
        app.daily("01:00", app.note, name="early")

    async with living(setup, "1970-01-01 12:00") as (diary, clock):
        await anyio.sleep(2 * DAY)
        (job,) = diary.jobs
        assert (diary.calls, job.next, job.note) == ([], None, "waits until the clock is set")
        clock.wall += datetime(2026, 6, 1, 12, tzinfo=ZoneInfo("Europe/Berlin")).timestamp() - clock.now()
        await anyio.sleep(DAY)
    assert [call[:8] for call in diary.calls] == ["06-02 01"]


async def test_a_job_that_still_runs_is_not_called_beside_itself() -> None:
    def setup(app: Diary) -> None:
        app.every("1h", app.work, name="one")
        app.every("1h", app.work, name="beside", mode="parallel")

    async with living(setup, "2026-06-01 12:00") as (diary, _):
        await anyio.sleep(2.1 * HOUR)
        one, beside = diary.jobs
        assert (one.runs.dropped, beside.runs.dropped) == (1, 0)
        since = one.runs.running_since
        assert since is not None
        assert f"{datetime.fromtimestamp(since, ZoneInfo('Europe/Berlin')):%H:%M}" == "13:00"
    assert [call[6:8] for call in diary.calls] == ["13", "13", "14"]


async def test_a_job_that_fails_stays_until_the_fifth_time_in_a_row() -> None:
    async with living(lambda app: app.every("1h", app.fail, name="odd"), "2026-06-01 12:00") as (diary, _):
        await anyio.sleep(4.5 * HOUR)
        (job,) = diary.jobs
        assert job.next is not None
        await anyio.sleep(5 * HOUR)
        assert job.next is None
        assert job.note == ("failed 5 times in a row and is not called any more (ValueError: odd)")
    assert len(diary.calls) == 5


async def test_two_jobs_of_one_name_are_an_error_that_names_both_lines() -> None:
    def setup(app: Diary) -> None:
        first = app.daily("22:00", app.note, name="evening")
        with pytest.raises(UsageError, match=r"two jobs are named 'evening': at (\S+:\d+) and at (\S+:\d+)") as caught:
            app.at("sunset", app.note, name="evening")
        assert first.where in str(caught.value)
        assert "at test_schedule.py:" in str(caught.value).partition(" and ")[2]

    async with living(setup, "2026-06-01 12:00") as (diary, _):
        assert len(diary.jobs) == 1


@pytest.mark.parametrize(
    ("zone", "start", "expected"),
    [
        ("Europe/Berlin", "2026-06-21 12:00", "06-21 21:03"),
        ("America/Los_Angeles", "2026-11-23 12:00", "11-23 16:15"),
        ("America/Los_Angeles", "2026-06-21 18:00", "06-21 19:37"),
    ],
)
async def test_the_sun_goes_by_the_local_date(zone: str, start: str, expected: str) -> None:
    async with living(lambda app: app.at("sunset", app.note, offset="-30m"), start, zone) as (diary, _):
        await anyio.sleep(12 * HOUR)
    (call,) = diary.calls
    found, wanted = (datetime.strptime(f"2026-{one[:11]}", "%Y-%m-%d %H:%M") for one in (call, expected))  # noqa: DTZ007
    assert abs(found - wanted) < timedelta(minutes=3)
    assert diary.causes == ["sunset -30m"]


@pytest.mark.parametrize("start", ["2026-06-01 12:00", "2026-12-01 12:00"])
async def test_where_the_sun_does_not_set_nothing_is_called_and_it_is_said(start: str) -> None:
    async with living(lambda app: app.at("sunset", app.note), start, "Europe/Oslo") as (diary, _):
        await anyio.sleep(3 * DAY)
        (job,) = diary.jobs
        assert (diary.calls, job.note) == ([], "no sunset today")
        assert job.next is not None
        assert timedelta(days=20) < job.next - diary.now() < timedelta(days=70)


async def test_an_offset_over_midnight_belongs_to_the_date_of_the_sun() -> None:
    """Three hours after a sunset at half past nine, each day once."""
    async with living(lambda app: app.at("sunset", app.note, offset="3h"), "2026-06-21 12:00") as (diary, _):
        await anyio.sleep(3 * DAY)
    assert [call[:8] for call in diary.calls] == ["06-22 00", "06-23 00", "06-24 00"]


async def test_jitter_moves_each_call_a_little_and_calls_each_day_once() -> None:
    async with living(lambda app: app.at("noon", app.note, jitter="20m", name="noon"), "2026-06-01 00:00") as (
        diary,
        _,
    ):
        await anyio.sleep(20 * DAY)
    minutes = [int(call[6:8]) * 60 + int(call[9:11]) for call in diary.calls]
    assert len(minutes) == 20
    assert max(minutes) - min(minutes) > 15
    assert all(12 * 60 + 46 <= one <= 13 * 60 + 30 for one in minutes)


async def test_days_of_the_week_are_those_that_are_named() -> None:
    async with living(lambda app: app.daily("07:00", app.note, days="fri-sun,tue"), "2026-06-01 00:00") as (diary, _):
        await anyio.sleep(7 * DAY)
    assert [call[:5] for call in diary.calls] == ["06-02", "06-05", "06-06", "06-07"]


async def test_a_cancelled_job_is_called_no_longer() -> None:
    async with living(lambda app: app.after("5m", app.note), "2026-06-01 12:00") as (diary, _):
        (job,) = diary.jobs
        job.cancel()
        job.cancel()
        diary.after(timedelta(minutes=1), diary.note)
        diary.after(30, diary.note)
        await anyio.sleep(HOUR)
        assert diary.jobs == ()
    assert diary.calls == ["06-01 12:00:30", "06-01 12:01:00"]


async def test_a_job_that_was_cancelled_and_is_there_again_after_days_was_not_missed() -> None:
    """A routine that waits for a time warned that the last night's was skipped."""
    async with living(lambda app: app.daily("22:00", app.note), "2026-06-01 20:00") as (diary, _):
        await anyio.sleep(3 * HOUR)
        diary.jobs[0].cancel()
        await anyio.sleep(3 * DAY)
        with capture_logs() as lines:
            diary.daily("22:00", diary.note)
            await anyio.sleep(DAY)
    assert diary.calls == ["06-01 22:00:00", "06-05 22:00:00"]
    assert [line["event"] for line in lines if line["event"] == "app.job_skipped"] == []


async def test_the_sun_rises_on_each_day_also_if_it_does_so_at_midnight_utc() -> None:
    """In India in May: the sunrise of the 17th was left out."""
    async with living(lambda app: app.at("sunrise", app.note), "2026-05-15 12:00", "Asia/Kolkata") as (diary, _):
        await anyio.sleep(3 * DAY)
    assert [call[:11] for call in diary.calls] == ["05-16 05:30", "05-17 05:29", "05-18 05:29"]


@pytest.mark.parametrize(
    ("setup", "problem"),
    [
        (lambda app: app.daily("25:00", app.note), "'25:00' is not a time of day; write it like 22:00"),
        (lambda app: app.daily("22:00", app.note, days="mon-frj"), "days: there is no day 'frj'; did you mean fri"),
        (lambda app: app.at("sunste", app.note), "there is no event 'sunste' of the sun; did you mean sunset"),
        (lambda app: app.every("0s", app.note), "period: must be above 0"),
        (lambda app: app.after("two minutes", app.note), "delay: 'two minutes' is not a duration"),
        (lambda app: app.every("1h", app.note, mode="singel"), "mode: there is no 'singel'; did you mean single"),
        (lambda app: app.after("1h", lambda: None, name="x", durable=True), "a durable timer needs a name, and a meth"),
        (lambda app: app.after("1h", app.note, catch_up="1h"), "catch_up is for a durable timer"),
        (lambda app: app.daily("22:00", app.note, catch_up="90d"), "catch_up: 90d is more than 31 days"),
        (lambda app: app.daily("22:00", app.note, days=["mon"]), "days: ['mon'] is not a text; write it like mon-fri"),
        (lambda app: app.daily("22:00", app.note, days="monkey"), "days: there is no day 'monkey'; did you mean mon"),
        (
            lambda app: app.daily("22:00", app.note, days="mon-"),
            "days: there is no day ''; write it like mon-fri, sat,sun, 24 dec or may-sep",
        ),
        (lambda app: app.daily(22, app.note), "22 is not a time of day; write it like 22:00"),
        (lambda app: app.at(None, app.note), "there is no event None of the sun"),
        (lambda app: app.at("sunset", app.note, offset="400d"), "offset: 400d is more than 12 hours"),
        (lambda app: app.at("sunset", app.note, jitter="13h"), "jitter: 13h is more than 12 hours"),
        (lambda app: app.at("sunset", app.note, offset=None), "offset: None is not a duration"),
        (lambda app: app.after(None, app.note), "delay: None is not a duration"),
        (lambda app: app.after(1e300, app.note), "delay: 1e+300 is more than 100 years"),
        (lambda app: app.every(True, app.note), "period: True is not a duration"),
        (lambda app: app.every("1h", app.note, name=3), "name: 3 is not a text of one character or more"),
        (lambda app: app.after("1h", app.note, name=[3], durable=True), "a durable timer needs a name"),
        (lambda app: app.after("1h", app.note()), "handler: None is not a function; give it without parentheses"),
        (lambda app: app.daily("22:00", app.say), "handler: say is called with no argument: missing a required"),
        (lambda app: app.after("1h", app.say, args=("a", "b")), "handler: say is called with a, b: too many"),
        (
            lambda app: app.after("1h", app.say, args=(app,), name="x", durable=True),
            "diary: store['_timers'] takes text, numbers",
        ),
    ],
)
async def test_a_wrong_argument_is_named(setup: Callable[[Diary], object], problem: str) -> None:
    def check(app: Diary) -> None:
        with pytest.raises(UsageError) as caught:
            setup(app)
        assert str(caught.value).startswith(problem)

    async with living(check, "2026-06-01 12:00") as (diary, _):
        assert diary.jobs == ()
