"""Commands that are sent once, because a second sending might undo the first; in virtual time."""

import pytest
from tests.control.conftest import Home, OpenHome, ignore

from homebot.devices.handles import Handle, WindowCovering
from homebot.devices.outcomes import Confirmed, Evidence, NoAnswer
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time

TOLD_ONCE = [
    ("closure", "Garage door", "movement", "closed"),
    ("window_covering", "Blind", "movement", "open"),
    ("window_covering", "Blind", "position", 40.0),
    ("window_covering", "Blind", "tilt", 40.0),
    ("water_valve", "Garden", "valve", "open"),
    ("door_lock", "Front door", "lock", "locked"),
    ("siren", "Siren", "on_off", True),
    ("siren", "Siren", "siren_tone", "fire"),
    ("speaker", "Radio", "media", "http://radio.example/a.mp3"),
    ("x_alarm_panel", "Alarm", "alarm", "armed_away"),
    ("robotic_vacuum_cleaner", "Robot", "vacuum", "cleaning"),
    ("x_lawn_mower", "Mower", "mower", "mowing"),
    ("switch", "Gate", "on_off", True),
    ("plug", "Boiler", "on_off", True),
]
REPEATED: list[tuple[str, str, str, PlainValue]] = [
    ("light", "Lamp", "on_off", True),
    ("plug", "Desk", "on_off", False),
    ("thermostat", "Hall", "heating_setpoint", 21.0),
    ("fan", "Fan", "fan_speed", 50.0),
]


async def sendings(open_home: OpenHome, kind: str, name: str, capability: str, value: PlainValue) -> int:
    """Command a device that does not answer, and return how often the command was sent."""
    async with open_home(grants={"/app": ("act: all",)}) as home:
        home.put("device", kind, capability, name=name)
        home.behaviours["device"] = ignore
        handle = await home.handle(Handle)
        assert isinstance(await handle.command(capability, value), NoAnswer)
        return len(home.commands)


@pytest.mark.parametrize(("kind", "name", "capability", "value"), TOLD_ONCE)
async def test_a_command_that_a_second_sending_might_undo_is_sent_once(
    open_home: OpenHome, kind: str, name: str, capability: str, value: PlainValue
) -> None:
    assert await sendings(open_home, kind, name, capability, value) == 1


@pytest.mark.parametrize(("kind", "name", "capability", "value"), REPEATED)
async def test_other_commands_without_an_answer_are_repeated(
    open_home: OpenHome, kind: str, name: str, capability: str, value: PlainValue
) -> None:
    assert await sendings(open_home, kind, name, capability, value) == 3


async def test_a_stop_that_changes_nothing_is_sent_once_and_was_accepted(home: Home) -> None:
    """Whether the blind stood still before is not known: many report only where they arrive."""
    blind = await home.new(WindowCovering, "blind", "movement", before={"movement": "open"}, behaviour=ignore)
    outcome = await blind.stop()
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, len(home.commands)) == (Evidence.ACKNOWLEDGED, 1)
