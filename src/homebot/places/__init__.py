"""Places in the house: its rooms, floors and doors, and the owner's statements about devices. Pure."""

from homebot.places.facts import NO_PLACES as NO_PLACES
from homebot.places.facts import FactName as FactName
from homebot.places.facts import OwnerFact as OwnerFact
from homebot.places.facts import Places as Places
from homebot.places.facts import Position as Position
from homebot.places.facts import read_position as read_position
from homebot.places.plan import NO_AREAS as NO_AREAS
from homebot.places.plan import OUTSIDE as OUTSIDE
from homebot.places.plan import HouseDoor as HouseDoor
from homebot.places.plan import HousePlan as HousePlan
from homebot.places.plan import HouseRoom as HouseRoom
from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.places.floor_plan import FloorPlan as FloorPlan
    from homebot.places.settings import PlacesSettings as PlacesSettings
    from homebot.places.settings import check_name as check_name
    from homebot.places.settings import read_places as read_places
    from homebot.places.settings import stated_position as stated_position
    from homebot.places.text import places_text as places_text

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.places.floor_plan": "FloorPlan",
            "homebot.places.settings": "PlacesSettings check_name read_places stated_position",
            "homebot.places.text": "places_text",
        },
    )
