"""Houses, virtual time and event logs for tests of programs that use homebot.

Each name is imported on first use, because pytest loads the plug-in of this package for every user.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from homebot.support.virtual_time import VirtualTimeLoop
    from homebot.testing.day import Day
    from homebot.testing.day_event import DayEvent
    from homebot.testing.day_live import live_day
    from homebot.testing.event_log import EventLog, HouseEvent
    from homebot.testing.gateway import FakeGateway, FakeGatewaySettings
    from homebot.testing.house import TestHouse, house_of
    from homebot.testing.virtual_house import VirtualHouse, virtual_house_of

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

_NAMES = {
    "homebot.testing.day": "Day",
    "homebot.testing.day_event": "DayEvent",
    "homebot.testing.day_live": "live_day",
    "homebot.testing.event_log": "EventLog HouseEvent",
    "homebot.testing.gateway": "FakeGateway FakeGatewaySettings",
    "homebot.testing.house": "TestHouse house_of",
    "homebot.testing.virtual_house": "VirtualHouse virtual_house_of",
    "homebot.support.virtual_time": "VirtualTimeLoop",
}
if not TYPE_CHECKING:  # otherwise a type checker would accept any name

    def __getattr__(name: str) -> object:
        if name not in __all__:  # a module of the package, which pytest's plug-in asks for in every program
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from homebot.support.lazy_names import lazy_names  # noqa: PLC0415 - on first use

        return lazy_names(__name__, _NAMES)(name)
