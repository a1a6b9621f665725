"""Places in the house: its rooms, floors and doors, and the owner's statements about devices. Pure."""

from homebot.places.facts import (
    NO_PLACES,
    FactName,
    OwnerFact,
    Places,
    Position,
    read_position,
)
from homebot.places.plan import NO_AREAS, OUTSIDE, HouseDoor, HousePlan, HouseRoom
from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.places.floor_plan import FloorPlan
    from homebot.places.settings import PlacesSettings, check_name, read_places, stated_position
    from homebot.places.text import places_text

__all__ = [
    "NO_AREAS",
    "NO_PLACES",
    "OUTSIDE",
    "FactName",
    "FloorPlan",
    "HouseDoor",
    "HousePlan",
    "HouseRoom",
    "OwnerFact",
    "Places",
    "PlacesSettings",
    "Position",
    "check_name",
    "places_text",
    "read_places",
    "read_position",
    "stated_position",
]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.places.floor_plan": "FloorPlan",
            "homebot.places.settings": "PlacesSettings check_name read_places stated_position",
            "homebot.places.text": "places_text",
        },
    )
