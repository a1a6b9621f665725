"""The simulated house, for a first look and for tests."""

from homebot.house.devices import SimulatedLamp, WindowMotor
from homebot.house.house import SimulatedHouse
from homebot.house.rooms import OUTSIDE, Room, Rooms
from homebot.house.simulated_device import Placed
from homebot.house.world import World
from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.house.description import family_world, load_world, office_world

__all__ = [
    "SimulatedHouse",
    "SimulatedLamp",
    "WindowMotor",
    "World",
    "family_world",
    "load_world",
    "office_world",
    "thesis_world",
]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(__name__, {"homebot.house.description": "family_world load_world office_world"})


def thesis_world() -> World:
    """Return the house of the thesis's experiment: two lamps, of which one is on, and a window motor."""
    rooms = {
        OUTSIDE: Room(window=1.0),
        "Room 405": Room(width=4.0, depth=5.0),
        "Hall": Room(x=4.0, width=4.0, depth=5.0),
        "Room 165": Room(x=8.0, width=4.0, depth=5.0),
    }
    placed = (
        Placed(SimulatedLamp("roomlights405", is_on=True), "Room 405", at=(1.0, 1.5)),
        Placed(SimulatedLamp("philips165"), "Room 165", at=(8.0, 1.5)),
        Placed(WindowMotor("firstlevel1"), "Hall", at=(4.0, 2.5)),
    )
    return World(Rooms(rooms, [("Room 405", "Hall"), ("Hall", "Room 165")]), placed)
