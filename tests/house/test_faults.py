"""Each fault does what it is called, to any device, and faults combine."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.house import faults
from homebot.house.devices import SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.faults import (
    Chatterbox,
    Deaf,
    EchoingBridge,
    Flapper,
    Late,
    Liar,
    Lossy,
    Reverter,
    Silent,
    Slow,
    Stuck,
    Unplugged,
    unwrap,
)
from homebot.house.sensors import MotionSensor, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice


def dice(seed: int = 1) -> random.Random:
    return random.Random(seed)  # noqa: S311  # no secrets


def said(device: SimulatedDevice, command: str, now: float) -> list[str]:
    return list(device.handle_command(command, now))


def test_a_lossy_device_loses_commands_and_words() -> None:
    """A fifth of each: about 64 of 100 commands are answered, 80 obeyed."""
    lamp = SimulatedLamp("lamp")
    lossy = Lossy(lamp, dice(), share=0.2)
    answered = obeyed = 0
    for number in range(1000):
        lamp.is_on = False
        answered += len(said(lossy, "on", float(number)))
        obeyed += lamp.is_on
    assert 600 < answered < 680
    assert 770 < obeyed < 830


def test_a_lossy_device_tells_at_a_heartbeat_how_it_is() -> None:
    """Not what the world heard last, which may be long over."""
    lamp = SimulatedLamp("lamp")
    lossy = Lossy(lamp, dice(), share=1.0)
    assert lossy.heartbeat() == ("off",)
    lamp.handle_command("on", 0.0)
    assert lossy.heartbeat() == ("on",)
    assert Deaf(lamp, dice()).heartbeat() is None


def test_a_slow_device_obeys_later_and_in_order() -> None:
    """Between once and one and a half times its delay."""
    slow = Slow(SimulatedLamp("lamp"), dice(), delay=4.0)
    assert said(slow, "on", 0.0) == []
    assert said(slow, "off", 0.5) == []
    assert (slow.state(), slow.advance(3.9)) == ("off", ())
    assert slow.advance(10.0) == ("on", "off")


def test_a_deaf_device_hears_nothing_but_hands() -> None:
    """It still says how it is."""
    deaf = Deaf(SimulatedLamp("lamp"), dice())
    assert said(deaf, "on", 0.0) == []
    assert deaf.state() == "off"
    assert deaf.operate_manually("on", 1.0) == ("on",)


def test_a_liar_reports_commands_and_does_nothing() -> None:
    """In the words of a device that did it; hands bring the truth back."""
    motor = WindowMotor("motor")
    liar = Liar(motor, dice())
    assert liar.state() == "closed"
    assert said(liar, "open", 0.0) == ["open"]
    assert (liar.state(), motor.state(), unwrap(liar)) == ("open", "closed", motor)
    assert liar.operate_manually("close", 1.0) == ("closed",)
    assert liar.state() == "closed"
    assert said(Liar(SimulatedDoorLock("lock"), dice()), "unlock", 0.0) == ["unlocked"]


def test_a_liar_may_begin_to_lie_later() -> None:
    """Before, it obeys: what watches it can learn how it is when it does."""
    lamp = SimulatedLamp("lamp")
    liar = Liar(lamp, dice(), since=10.0)
    assert (said(liar, "on", 9.0), lamp.is_on) == (["on"], True)
    assert (said(liar, "off", 10.0), lamp.is_on) == (["off"], True)


def test_an_echoing_bridge_reports_before_the_device_has_obeyed() -> None:
    """And hands the report of the device on."""
    slow = EchoingBridge(Slow(SimulatedLamp("lamp"), dice(), delay=2.0), dice())
    assert said(slow, "on", 0.0) == ["on"]
    assert (slow.state(), slow.advance(10.0)) == ("off", ("on",))
    stuck = EchoingBridge(Stuck(SimulatedDoorLock("lock"), dice()), dice())
    assert said(stuck, "unlock", 0.0) == ["unlocked"]
    assert stuck.advance(2.0) == ("locked",)


def test_a_stuck_device_answers_with_its_old_state() -> None:
    """After a while, once for all it was told meanwhile; hands and what a sensor feels change nothing."""
    stuck = Stuck(SimulatedLamp("lamp"), dice())
    assert said(stuck, "on", 0.0) == []
    assert said(stuck, "on", 1.0) == []
    assert (stuck.advance(1.9), stuck.advance(2.0), stuck.advance(60.0)) == ((), ("off",), ())
    assert stuck.operate_manually("on", 60.0) == ()
    contact = Stuck(SimulatedContactSensor("door"), dice())
    assert (contact.apply_input(1.0, 1.0), contact.state()) == ((), "closed")


def test_a_reverter_goes_back_after_a_while() -> None:
    """A motor all the way; a later command calls the older way back off."""
    motor = Reverter(WindowMotor("motor", travel_time=3.0), dice(), after=60.0)
    assert said(motor, "open", 0.0) == ["opening"]
    assert motor.advance(59.0) == ("open",)
    assert motor.advance(70.0) == ("closing", "closed")
    said(motor, "open", 100.0)
    said(motor, "0.5", 150.0)
    assert motor.advance(209.0) == ("0.5",)
    assert motor.advance(300.0) == ("opening", "open")


def test_a_reverter_brings_a_thermostat_back_to_its_target() -> None:
    """Which is not the temperature it says."""
    thermostat = SimulatedThermostat("room", celsius=20.0, target=20.0)
    reverter = Reverter(thermostat, dice(), after=10.0)
    said(reverter, "25", 0.0)
    assert reverter.advance(11.0) == ("20",)
    assert thermostat.target == 20.0


def test_a_chatterbox_says_everything_again_and_again() -> None:
    """Fifty times, a tenth of a second apart."""
    chatterbox = Chatterbox(SimulatedLamp("lamp"), dice())
    assert said(chatterbox, "on", 0.0) == ["on"]
    assert chatterbox.advance(1.05) == ("on",) * 10
    assert len(chatterbox.advance(60.0)) == 39


def test_held_reports_of_a_fault_are_bounded_and_counted() -> None:
    """The oldest is lost."""
    slow = Slow(SimulatedLamp("lamp"), dice(), delay=4.0)
    for _ in range(faults.HELD + 7):
        said(slow, "on", 0.0)
    assert slow.lost == 7
    assert len(slow.advance(100.0)) == faults.HELD


def test_a_flapper_says_the_opposite_and_takes_it_back() -> None:
    """About once an hour, and nothing else."""
    flapper = Flapper(SimulatedContactSensor("door"), dice(), every=3600.0)
    words = flapper.advance(100 * 3600.0)
    assert 70 < len(words) / 2 < 130
    assert set(zip(words[::2], words[1::2], strict=False)) == {("open", "closed")}


def test_a_late_sensor_tells_everything_after_its_delay() -> None:
    sensor = Late(MotionSensor("motion", hold=60.0), dice(), delay=30.0)
    assert sensor.apply_input(1.0, 10.0) == ()
    assert sensor.advance(39.0) == ()
    assert sensor.advance(40.0) == ("motion",)
    sensor.apply_input(0.0, 100.0)
    assert sensor.advance(1000.0) == ("clear",)


def test_a_silent_sensor_tells_nothing_from_a_time_on() -> None:
    sensor = Silent(MotionSensor("motion"), dice(), since=50.0)
    assert sensor.apply_input(1.0, 10.0) == ("motion",)
    assert sensor.heartbeat() is None
    assert sensor.apply_input(0.0, 60.0) == ()
    assert sensor.advance(1000.0) == ()
    assert sensor.heartbeat() == ()
    assert sensor.state() == "clear"


def test_an_unplugged_device_hears_does_and_says_nothing() -> None:
    """Until its plug is back; then it says how it is."""
    lamp = Unplugged(SimulatedLamp("lamp", is_on=True), dice(), since=10.0, until=20.0)
    assert said(lamp, "on", 5.0) == ["on"]
    lamp.advance(12.0)
    assert (said(lamp, "off", 12.0), lamp.operate_manually("off", 12.0), lamp.watts()) == ([], (), 0.0)
    assert said(lamp, "off", 20.0) == ["on", "off"]


def test_a_sensor_applies_a_lasting_input_when_its_power_is_back() -> None:
    """And says only that."""
    contact = Unplugged(SimulatedContactSensor("door"), dice(), since=0.0, until=9.0)
    assert (contact.apply_input(1.0, 1.0), contact.state(), contact.has_power) == ((), "closed", False)
    assert contact.advance(10.0) == ("open",)
    assert contact.has_power


def test_faults_combine_from_the_device_outwards() -> None:
    """A slow chatterbox that is unplugged in the end."""
    box = Chatterbox(Slow(SimulatedLamp("lamp"), dice(), delay=2.0), dice(), times=3, every=1.0)
    lamp = Unplugged(box, dice(), since=5.0)
    assert said(lamp, "on", 0.0) == []
    assert lamp.advance(100.0) == ("on", "on", "on")
    assert isinstance(unwrap(lamp), SimulatedLamp)


KINDS = [Lossy, Slow, Deaf, Liar, EchoingBridge, Stuck, Reverter, Chatterbox, Flapper, Late, Silent, Unplugged]


@given(
    st.lists(st.sampled_from(KINDS), max_size=4),
    st.lists(st.tuples(st.sampled_from(["open", "close", "stop", "0.5", "?"]), st.floats(0.0, 100.0)), max_size=8),
    st.integers(),
)
def test_any_faults_behave_the_same_for_the_same_dice_and_time_goes_on(
    kinds: list[type[faults.DeviceFault]], commands: list[tuple[str, float]], seed: int
) -> None:
    """Two of a kind, told the same, say the same; advancing always ends."""

    def run() -> list[str]:
        rng = dice(seed)
        device: SimulatedDevice = WindowMotor("motor")
        for kind in kinds:
            device = kind(device, rng)
        words, now = [], 0.0
        for command, after in commands:
            now += after
            words += said(device, command, now)
        words += device.advance(now + 1000.0)
        assert (following := device.next_event()) is None or following > now + 1000.0
        return words

    assert run() == run()


@pytest.mark.parametrize("kind", KINDS)
def test_every_fault_keeps_the_name_of_its_device(kind: type[faults.DeviceFault]) -> None:
    """Its docstring is one line."""
    device = kind(SimulatedLamp("lamp"), dice())
    assert (device.device_id, device.service_type) == ("lamp", "lights")
    assert kind.__doc__
    assert "\n" not in kind.__doc__
