"""Houses, virtual time and event logs for tests of programs that use homebot.

Each name is imported when it is first asked for: pytest loads the plug-in of this package for everybody.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from homebot.testing.day import Day
    from homebot.testing.day_event import DayEvent
    from homebot.testing.day_live import live_day
    from homebot.testing.event_log import EventLog, HouseEvent
    from homebot.testing.gateway import FakeGateway, FakeGatewaySettings
    from homebot.testing.house import TestHouse, house_of
    from homebot.testing.virtual_house import VirtualHouse, virtual_house_of
    from homebot.testing.virtual_time import VirtualTimeLoop

__all__ = [
    "Day",
    "DayEvent",
    "EventLog",
    "FakeGateway",
    "FakeGatewaySettings",
    "HouseEvent",
    "TestHouse",
    "VirtualHouse",
    "VirtualTimeLoop",
    "house_of",
    "live_day",
    "virtual_house_of",
]

_HOMES = {
    "Day": "day",
    "DayEvent": "day_event",
    "EventLog": "event_log",
    "FakeGateway": "gateway",
    "FakeGatewaySettings": "gateway",
    "HouseEvent": "event_log",
    "TestHouse": "house",
    "VirtualHouse": "virtual_house",
    "VirtualTimeLoop": "virtual_time",
    "house_of": "house",
    "live_day": "day_live",
    "virtual_house_of": "virtual_house",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
