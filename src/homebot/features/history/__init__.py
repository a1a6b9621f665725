"""History: measurements and states of devices, kept for years in little space."""

from typing import Final

from homebot.feature import Feature, FeatureTable, RunFacts, Verb
from homebot.rights import OfferedService, Right

READ_HISTORY: Final = OfferedService("/history/read", Right.READ)
CORRECT_HISTORY: Final = OfferedService("/history/correct", Right.MANAGE)
READ_ENERGY: Final = OfferedService("/history/energy", Right.READ)

HISTORY_FILE: Final = "history.sqlite"
"""The name of the file, beside that of the directory."""


def _is_kept(house: RunFacts) -> bool:
    settings = house.table("history")
    return house.keeps_data if settings is None or settings.enabled is None else bool(settings.enabled)


FEATURE: Final = Feature(
    name="history",
    services=(READ_HISTORY, CORRECT_HISTORY, READ_ENERGY),
    runs="homebot.features.history.history:record_history",
    is_wanted=_is_kept,
    files={HISTORY_FILE: "homebot.features.history.history_file:HISTORY_SCHEMA"},
    tables={"history": FeatureTable("homebot.features.history.settings:read_history")},
    verbs={
        "history": Verb(
            "show past measurements as a table, a plot, CSV or JSON; energy by day",
            "homebot.features.history.command:add_arguments",
            after="journal",
        )
    },
    routes="homebot.features.history.http:ROUTES",
    tools="homebot.features.history.agent_tools:add_tools",
)
