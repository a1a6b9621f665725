"""The page's own data and services: the owner's order for all screens, the use of devices, and the setup."""

from typing import Final

from homebot.feature import Feature, FeatureTable
from homebot.rights import OfferedService, Right

CHANGE_LAYOUT: Final = OfferedService("/page/change_layout", Right.ACT)
GET_USAGE: Final = OfferedService("/page/usage", Right.READ)
GET_PICTURE: Final = OfferedService("/page/picture", Right.READ)
LIST_PICTURES: Final = OfferedService("/page/pictures", Right.READ)
FIND_UNUSED: Final = OfferedService("/setup/found", Right.READ, "homebot/srv/FindUnused")
CHANGE_SETUP: Final = OfferedService("/setup/change", Right.MANAGE, "homebot/srv/ChangeSetup")
READ_TABLE: Final = OfferedService("/setup/table", Right.MANAGE, "homebot/srv/ReadTable")
GET_BACKUP: Final = OfferedService("/setup/backup", Right.MANAGE, "homebot/srv/GetBackup")
MAKE_TOKEN: Final = OfferedService("/setup/token", Right.MANAGE, "homebot/srv/MakeToken")
SETUP: Final = (FIND_UNUSED, CHANGE_SETUP, READ_TABLE, GET_BACKUP, MAKE_TOKEN)

LAYOUT: Final = "/page/layout"
"""The topic of the present layout."""

FEATURE: Final = Feature(
    name="page",
    services=(CHANGE_LAYOUT, GET_USAGE, GET_PICTURE, LIST_PICTURES, *SETUP),
    runs="homebot.features.page.page:serve_page",
    tables={"pictures": FeatureTable("homebot.features.page.pictures:read_pictures")},
    messages=(
        "homebot.devices.picture_messages",
        "homebot.features.page.messages",
        "homebot.features.page.setup_messages",
    ),
)
