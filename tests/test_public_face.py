"""What ``import homebot`` gives: names that an app may rely on, each imported when it is first asked for."""

import importlib
import subprocess
import sys

import pytest

import homebot
from homebot.devices.outcomes import OUTCOMES

pytestmark = pytest.mark.slow

NAMES = """
App run Runtime Config load_config parse_config configure_logging
Device DeviceChange DevicePart Devices Follow RawMessage State StateChange Capability ExposedDevice Part
AirConditioner AlarmPanel Closure ContactSensor DoorLock ElectricalMeter Fan Handle HumiditySensor LawnMower Light
LightSensor MediaPlayer OccupancySensor Plug PressureSensor RoboticVacuumCleaner Siren SmokeAlarm Switch
TemperatureSensor Thermostat WaterLeakDetector WaterValve WindowCovering
FollowHandles HandleChange
AlreadySo Confirmed Contradicted Evidence Gone NoAnswer Outcome Refused Reverted Superseded
ClosedError ConfigError HomebotError LinkError PeerError RefusedError ServiceError ServiceFailedError ServiceGoneError
ServiceTimeoutError ServiceUnavailableError UsageError WrongCodeError
Client DurabilityPolicy Graph HistoryPolicy LivelinessPolicy Message Node Publisher QoSProfile ReliabilityPolicy Service
ServiceType Subscription Timer qos_profile_default qos_profile_latched qos_profile_sensor_data __version__
"""


def test_these_names_and_every_kind_of_handle_and_outcome_are_there() -> None:
    """Apps rely on them: one that goes or changes is a change for every app, to be written in the changelog."""
    handles = importlib.import_module("homebot.devices.handles")
    found = [*OUTCOMES.values(), *(getattr(handles, name) for name in handles.__all__)]
    bases = (homebot.Handle, homebot.Outcome)
    kinds = {one.__name__ for one in found if isinstance(one, type) and issubclass(one, bases)}
    assert kinds | set(NAMES.split()) <= set(homebot.__all__)


def test_each_name_is_the_thing_of_its_package() -> None:
    for name in homebot.__all__:
        found = getattr(homebot, name)
        if name != "__version__" and not name.startswith("qos_"):
            assert getattr(importlib.import_module(found.__module__), name) is found


def test_dir_lists_them() -> None:
    assert set(homebot.__all__) <= set(dir(homebot))


def test_an_unknown_name_is_an_error_that_names_it() -> None:
    with pytest.raises(AttributeError, match="module 'homebot' has no attribute 'Lihgt'"):
        _ = homebot.Lihgt  # type: ignore[attr-defined]
    with pytest.raises(ImportError, match="Lihgt"):
        from homebot import Lihgt  # type: ignore[attr-defined]  # noqa: F401, PLC0415


def test_a_name_that_is_not_asked_for_costs_nothing() -> None:
    """Not even ``typing`` is imported with homebot; a handle needs no runtime, an error nothing but its file."""
    code = """
import sys
before = set(sys.modules)
import homebot
assert set(sys.modules) - before == {"homebot"}, set(sys.modules) - before
from homebot import LinkError
assert "pydantic" not in sys.modules
from homebot import App, Light
assert not {"homebot.runtime", "homebot.gateways", "homebot.cli"} & set(sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_all_names_come_with_a_star() -> None:
    code = "from homebot import *; print(Light.__name__, run.__name__, LinkError.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert (done.stdout, done.stderr) == ("Light run LinkError\n", "")
