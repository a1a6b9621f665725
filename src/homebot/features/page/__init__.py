"""The page's own data, the same for all screens: the owner's order, and the use of devices."""

from typing import Final

from homebot.feature import Feature
from homebot.rights import OfferedService, Right

CHANGE_LAYOUT: Final = OfferedService("/page/change_layout", Right.ACT)
GET_USAGE: Final = OfferedService("/page/usage", Right.READ)

LAYOUT: Final = "/page/layout"
"""The topic of the present layout."""

FEATURE: Final = Feature(
    name="page",
    services=(CHANGE_LAYOUT, GET_USAGE),
    runs="homebot.features.page.page:serve_page",
    messages=("homebot.features.page.messages",),
)
