"""A house lives: its people, its devices and the sun share one time line."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from homebot.errors import UsageError
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.event_log import Event, WorldLog
from homebot.house.faults import Chatterbox, Deaf, Liar, Reverter, Unplugged
from homebot.house.household import Habit, Person
from homebot.house.robot import Robot
from homebot.house.rooms import DAY, OUTSIDE, Room, Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import Placed, ScheduledCommand
from homebot.house.world import World

PLAN = Rooms(
    {OUTSIDE: Room(window=1.0), "hall": Room(window=0.0), "living": Room(x=5.0, window=0.02)},
    [(OUTSIDE, "hall"), ("hall", "living")],
)
SEVEN = 7 * 3600.0
NOON = DAY / 2


def lines(world: World, now: float) -> list[str]:
    return [str(event) for event in world.run_until(now)]


def anna(*habits: Habit, starts_in: str = OUTSIDE) -> Person:
    return Person("anna", habits, starts_in, asleep=False)


def test_a_person_coming_home_opens_the_door_is_detected_and_makes_light() -> None:
    """And leaves the dark behind."""
    world = World(
        PLAN,
        [
            Placed(SimulatedContactSensor("door"), "hall", door=OUTSIDE),
            Placed(MotionSensor("motion", hold=60.0), "hall"),
            Placed(SimulatedLamp("hall_lamp"), "hall"),
        ],
        [anna(Habit(SEVEN, "living"))],
    )
    assert lines(world, SEVEN + 300.0) == [
        "0 07:00:01.000 anna enters hall",
        "0 07:00:01.000 door says open",
        "0 07:00:01.000 motion says motion",
        "0 07:00:01.000 hall_lamp switch on",
        "0 07:00:01.000 hall_lamp says on",
        "0 07:00:04.000 door says closed",
        "0 07:00:06.000 anna enters living",
        "0 07:00:06.000 hall_lamp switch off",
        "0 07:00:06.000 hall_lamp says off",
        "0 07:01:06.000 motion says clear",
    ]
    assert world.people_in("living") == ("anna",)


def test_people_unlock_the_door_they_go_through_and_lock_it_behind_them() -> None:
    """Two who come one after the other lock it once."""
    habits = Habit(SEVEN, "hall")
    people = [Person("anna", [habits]), Person("ben", [Habit(SEVEN + 10.0, "hall")])]
    world = World(PLAN, [Placed(SimulatedDoorLock("lock"), "hall", door=OUTSIDE)], people)
    words = [line.partition(" lock ")[2] for line in lines(world, SEVEN + 60.0) if " lock says" in line]
    assert words.count("says locked") == 1
    assert words[-1] == "says locked"


def test_a_sleeping_person_is_in_the_dark_and_not_detected() -> None:
    """The lamp goes off when they lie down."""
    devices = [Placed(SimulatedLamp("lamp"), "hall"), Placed(MotionSensor("motion"), "hall")]
    world = World(PLAN, devices, [anna(Habit(100.0, "hall"), Habit(200.0, "hall", asleep=True))])
    text = "\n".join(lines(world, 1000.0))
    assert "0 00:03:20.000 anna sleeps hall\n0 00:03:20.000 lamp switch off" in text
    assert "0 00:04:20.000 motion says clear" in text


def test_a_person_with_a_new_goal_on_the_way_turns_round() -> None:
    """The first way ends where they are."""
    world = World(PLAN, [], [anna(Habit(100.0, "living"), Habit(103.0, OUTSIDE))])
    assert [event.what for event in world.run_until(1000.0)] == ["hall", OUTSIDE]


def test_people_can_leave_the_lamps_alone() -> None:
    """Then light is the business of others."""
    world = World(PLAN, [Placed(SimulatedLamp("lamp"), "hall")], [anna(Habit(100.0, "hall"))], by_hand=False)
    assert lines(world, 1000.0) == ["0 00:01:41.000 anna enters hall"]


def test_a_person_at_home_makes_light_when_it_gets_dark() -> None:
    """Once; who is told off stays off."""
    world = World(PLAN, [Placed(SimulatedLamp("lamp"), "living")], [anna(starts_in="living")])
    switched = [event for event in world.run_until(DAY) if event.verb == "switch"]
    assert [event.what for event in switched] == ["on"]
    assert 17 * 3600 < switched[0].at < 18.5 * 3600


def test_the_sun_comes_in_as_far_as_covers_let_it() -> None:
    """And lamps add to it."""
    cover, lamp = CoverMotor("cover"), SimulatedLamp("lamp", rated_lux=150.0)
    world = World(PLAN, [Placed(cover, "living"), Placed(lamp, "living"), Placed(LuxSensor("lux"), "living")])
    world.run_until(NOON)
    bright = world.lux("living")
    assert bright > 1000.0
    world.command("cover", "0.5", NOON)
    world.run_until(NOON + 60.0)
    assert world.lux("living") == pytest.approx(bright / 2, rel=0.01)
    assert float(world.device("lux").state()) == pytest.approx(bright / 2, rel=0.2)
    world.command("cover", "close", NOON + 60.0)
    world.run_until(NOON + 120.0)
    assert world.lux("living") == 0.0
    assert [str(event) for event in world.command("lamp", "on", NOON + 120.0)][-2:] == [
        "0 12:02:00.000 lamp says on",
        "0 12:02:00.000 lux says 150",
    ]


def test_looking_at_a_device_changes_nothing() -> None:
    """Also while it moves, when the sun is looked at."""

    def text(*, looks: bool) -> str:
        world = World(
            PLAN, [Placed(CoverMotor("cover", travel_time=600.0), "living"), Placed(LuxSensor("lux"), "living")]
        )
        world.command("cover", "close", NOON + 10.0)
        for second in range(0, 900, 7):
            world.run_until(NOON + 10.0 + second)
            if looks:
                world.device("cover")
        return world.event_log.text()

    assert text(looks=True) == text(looks=False)


def test_the_power_meter_reports_the_sum_of_all_devices() -> None:
    """Also of what draws power by itself."""
    devices = [
        Placed(PowerMeter("meter"), "hall"),
        Placed(SimulatedLamp("lamp", rated_watts=10.0), "hall"),
        Placed(WindowMotor("window", travel_time=3.0), "hall"),
    ]
    world = World(PLAN, devices)
    world.command("lamp", "on", 1.0)
    world.command("window", "open", 1.0)
    world.run_until(10.0)
    said = [(event.at, event.what) for event in world.event_log.since(0) if event.who == "meter"]
    assert said == [(1.0, "10"), (1.0, "50"), (4.0, "10")]


def test_a_metering_plug_reports_the_power_of_its_device() -> None:
    """Whatever else is on, and whatever the device says."""
    devices = [
        Placed(PowerMeter("plug", of="lamp"), "hall"),
        Placed(Liar(SimulatedLamp("lamp", rated_watts=10.0), random.Random(1), since=2.0), "hall"),  # noqa: S311
        Placed(SimulatedLamp("other"), "hall"),
    ]
    world = World(PLAN, devices)
    for at, name, command in ((1.0, "lamp", "on"), (1.5, "other", "on"), (2.0, "lamp", "off")):
        world.command(name, command, at)
    said = [(event.at, event.what) for event in world.event_log.since(0) if event.who == "plug"]
    assert said == [(1.0, "10")]


def test_a_liar_draws_its_real_power() -> None:
    """Its words change no physics."""
    lamp = Liar(SimulatedLamp("lamp"), random.Random(1))  # noqa: S311  # no secrets
    world = World(PLAN, [Placed(lamp, "hall"), Placed(PowerMeter("meter"), "hall")])
    assert [event.what for event in world.command("lamp", "on", 1.0)] == ["on", "on"]
    assert (world.device("lamp").state(), world.device("meter").state(), world.lux("hall")) == ("on", "0", 0.0)


def test_hands_reach_a_deaf_lamp() -> None:
    """Its radio is broken, its switch is not."""
    lamp = Deaf(SimulatedLamp("lamp"), random.Random(1))  # noqa: S311  # no secrets
    world = World(PLAN, [Placed(lamp, "hall")], [anna(Habit(100.0, "hall"))])
    assert lines(world, 200.0)[-1] == "0 00:01:41.000 lamp says on"
    assert [event.verb for event in world.command("lamp", "off", 200.0)] == ["told"]


def test_the_weather_reaches_the_thermostat() -> None:
    """A house that nobody heats is cold in the morning."""
    world = World(PLAN, [Placed(SimulatedThermostat("heat", target=5.0), "hall")], first_day=22)
    world.run_until(SEVEN)
    assert float(world.device("heat").state()) < 15.0


def test_timers_tell_devices_every_day() -> None:
    """At their time."""
    world = World(PLAN, [Placed(SimulatedLamp("lamp"), "hall")], errands=[ScheduledCommand(SEVEN, "lamp", "on")])
    told = [event.at for event in world.run_until(2 * DAY) if event.verb == "told"]
    assert told == [SEVEN, DAY + SEVEN]


def test_an_errand_waits_until_its_device_is_no_longer_reserved_and_its_sender_is_named() -> None:
    """As for the drive of a goal."""
    robot = Robot("robot", PLAN, "hall")
    world = World(PLAN, [Placed(robot, "hall")], errands=[ScheduledCommand(SEVEN, "robot", "stop")])
    robot.reserved_until = SEVEN + 300.0
    assert lines(world, SEVEN + 299.0) == []
    assert robot.last_sender == ""
    assert len(lines(world, SEVEN + 301.0)) == 2
    assert robot.last_sender == "an errand of the house"


def test_a_house_run_in_steps_is_the_house_run_at_once() -> None:
    """Whoever carries it sleeps until its next event."""
    devices = [
        Placed(SimulatedLamp("lamp"), "hall"),
        Placed(CoverMotor("cover"), "living"),
        Placed(LuxSensor("lux"), "living"),
    ]
    people = [anna(Habit(SEVEN, "living", jitter=600.0), Habit(2 * SEVEN, OUTSIDE))]

    def house() -> World:
        return World(PLAN, [Placed(type(d.device)(d.device.device_id), d.room) for d in devices], people, seed=3)

    at_once, in_steps = house(), house()
    at_once.run_until(DAY)
    heard: list[Event] = []
    while in_steps.next_event() <= DAY:
        heard += in_steps.run_until(in_steps.next_event())
    assert "".join(f"{event}\n" for event in heard) == at_once.event_log.text()


@settings(max_examples=10, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 3000.0), st.sampled_from(["lamp", "cover"]), st.sampled_from(["on", "0.3", "open", "stop"])
        )
    ),
    st.integers(),
)
def test_the_same_house_told_the_same_writes_the_same(orders: list[tuple[float, str, str]], seed: int) -> None:
    """Byte for byte, in time order, whatever it is told."""

    def text() -> str:
        lamp = Reverter(SimulatedLamp("lamp"), random.Random(seed), after=90.0)  # noqa: S311  # no secrets
        people = [anna(Habit(SEVEN, "living", jitter=7000.0), starts_in="hall")]
        world = World(PLAN, [Placed(lamp, "hall"), Placed(CoverMotor("cover"), "living")], people, seed=seed)
        now = 0.0
        for after, device_id, command in orders:
            now += after
            world.command(device_id, command, now)
        world.run_until(now + DAY)
        times = [event.at for event in world.event_log.since(0)]
        assert times == sorted(times)
        return world.event_log.text()

    assert text() == text()


def test_a_house_keeps_the_newest_events() -> None:
    """As many events as it was told to."""
    world = World(PLAN, [Placed(SimulatedLamp("lamp"), "hall")], capacity=3)
    for second in range(5):
        world.command("lamp", "on", float(second))
    assert (len(world.event_log.since(0)), world.event_log.dropped) == (3, 7)


def test_commands_without_end_do_not_fill_the_agenda() -> None:
    """A motor that is told back and forth plans one arrival; those called off are swept."""
    world = World(PLAN, [Placed(CoverMotor("cover"), "living")])
    planned = set()
    for number in range(2000):
        world.command("cover", ("close", "open")[number % 2], 1.0 + number / 100)
        planned.add(len(world._queue._heap))
    assert max(planned) < 200


def test_a_command_of_any_length_is_kept_short() -> None:
    """The event log is bounded."""
    world = World(PLAN, [Placed(SimulatedLamp("lamp"), "hall")])
    (told,) = world.command("lamp", "x" * 100_000, 1.0)
    assert told.what == "x" * 200


@pytest.mark.parametrize(
    ("build", "problem"),
    [
        (
            lambda: World(PLAN, [Placed(SimulatedLamp("lamp"), "hall"), Placed(SimulatedLamp("lamp"), "hall")]),
            "two devices",
        ),
        (lambda: World(PLAN, [Placed(SimulatedLamp("lamp"), "attic")]), "attic"),
        (lambda: World(PLAN, [Placed(SimulatedContactSensor("door"), "hall", door="attic")]), "attic"),
        (lambda: World(PLAN, [], [anna(Habit(1.0, "attic"))]), "attic"),
        (lambda: World(PLAN, [], [anna(starts_in="attic")]), "attic"),
        (lambda: World(PLAN, [], errands=[ScheduledCommand(1.0, "lamp", "on")]), "no device 'lamp'"),
        (lambda: World(PLAN, []).command("lamp", "on", 1.0), "no device 'lamp'"),
        (lambda: World(PLAN, []).device("lamp"), "no device 'lamp'"),
        (lambda: World(PLAN, []).lux("attic"), "no room 'attic'"),
        (lambda: World(PLAN, []).run_until(float("inf")), "inf"),
    ],
)
def test_an_unknown_device_or_room_is_refused(build: object, problem: str) -> None:
    """With its name."""
    assert callable(build)
    with pytest.raises(UsageError, match=problem):
        build()


def test_a_robot_is_seen_on_its_way_and_opens_doors_but_no_locks() -> None:
    """And works no switches."""
    world = World(
        PLAN,
        [
            Placed(Robot("robot", PLAN, "living", speed=1.0), "living"),
            Placed(SimulatedContactSensor("door"), "living", door="hall"),
            Placed(SimulatedDoorLock("lock"), "living", door="hall"),
            Placed(MotionSensor("hall_motion", hold=10.0), "hall"),
            Placed(MotionSensor("living_motion", hold=10.0), "living"),
            Placed(SimulatedLamp("hall_lamp"), "hall"),
        ],
    )
    world.command("robot", "go hall", 0.0)
    assert lines(world, 60.0) == [
        "0 00:00:05.000 robot says hall",
        "0 00:00:05.000 door says open",
        "0 00:00:08.000 door says closed",
        "0 00:00:15.000 living_motion says clear",
    ]
    world.command("robot", "go living", 60.0)
    assert lines(world, 64.0) == []
    assert [str(event) for event in world.command("robot", "stop", 64.0)] == [
        "0 00:01:04.000 robot told stop",
        "0 00:01:04.000 robot says hall",
    ]
    assert lines(world, 80.0) == ["0 00:01:14.000 hall_motion says clear"]


def test_a_robot_with_a_larger_plan_leaves_the_house() -> None:
    """Nobody sees it there."""
    world = World.of(Robot("robot", PLAN, "living"))
    world.command("robot", "go hall", 0.0)
    assert lines(world, 60.0) == ["0 00:00:10.000 robot says hall"]


def test_a_caller_operates_a_switch_by_hand() -> None:
    """As those who live there do; a deaf lamp obeys hands."""
    world = World.of(Deaf(SimulatedLamp("lamp"), random.Random(0)))  # noqa: S311  # no secrets
    assert [str(event) for event in world.command("lamp", "on", 1.0)] == ["0 00:00:01.000 lamp told on"]
    assert [str(event) for event in world.press("lamp", "on", 2.0)] == [
        "0 00:00:02.000 lamp switch on",
        "0 00:00:02.000 lamp says on",
    ]
    with pytest.raises(UsageError, match="there is no device 'door'"):
        world.press("door", "open", 3.0)


def test_a_device_without_power_is_silent_and_says_how_it_is_when_it_has_some_again() -> None:
    """Whatever fault is around that one."""
    rng = random.Random(0)  # noqa: S311  # no secrets
    world = World.of(Chatterbox(Unplugged(SimulatedLamp("lamp"), rng, since=10.0, until=20.0), rng, times=3, every=4.0))
    world.command("lamp", "on", 5.0)
    assert lines(world, 100.0) == [
        "0 00:00:09.000 lamp says on",
        "0 00:00:10.000 lamp power off",
        "0 00:00:20.000 lamp power on",
        "0 00:00:20.000 lamp says on",
        "0 00:00:24.000 lamp says on",
        "0 00:00:28.000 lamp says on",
    ]


def test_forgetful_people_turn_lamps_on_and_leave_them_on() -> None:
    habits = (Habit(100.0, "hall"), Habit(200.0, OUTSIDE))
    lamps = {}
    for forgetful in (False, True):
        lamp = SimulatedLamp("lamp")
        World(PLAN, [Placed(lamp, "hall")], [anna(*habits)], forgetful=forgetful).run_until(1000.0)
        lamps[forgetful] = lamp.state()
    assert lamps == {False: "off", True: "on"}


def test_an_event_is_one_line_with_day_time_and_fact() -> None:
    """To the millisecond; rounding carries into the next day."""
    assert str(Event(90_061.5, "lamp", "says", "on")) == "1 01:01:01.500 lamp says on"
    assert str(Event(86_399.9999, "anna", "enters", "hall")) == "1 00:00:00.000 anna enters hall"


def test_a_report_with_line_breaks_is_one_line() -> None:
    """A lamp cannot be made to forge what happened."""
    assert str(Event(0.0, "lamp", "told", "on\n0 x")) == "0 00:00:00.000 lamp told 'on\\n0 x'"


def test_a_full_log_drops_the_oldest_and_counts() -> None:
    """What came since a mark comes as far as it is kept."""
    log = WorldLog(capacity=3)
    events = [Event(float(number), "lamp", "says", "on") for number in range(5)]
    for event in events:
        log.add(event)
    assert (log.count, log.dropped) == (5, 2)
    assert log.since(4) == (events[4],)
    assert log.since(0) == tuple(events[2:])
    assert log.since(5) == ()
    assert log.text() == "".join(f"{event}\n" for event in events[2:])


def test_an_errand_waits_for_a_robot_that_somebody_else_uses() -> None:
    robot = Robot("robot", PLAN, "hall")
    world = World(PLAN, [Placed(robot, "hall")], errands=[ScheduledCommand(SEVEN, "robot", "go living")])
    robot.reserved_until = SEVEN + 600.0
    assert not any("told" in line for line in lines(world, SEVEN + 599.0))
    assert any("robot told go living" in line for line in lines(world, SEVEN + 700.0))
    assert robot.last_sender == "an errand of the house"
