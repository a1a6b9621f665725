"""Routines: rules of the owner as data, each of which is an app."""

from typing import Final

from homebot.feature import Feature, FeatureTable

FEATURE: Final = Feature(
    name="routines",
    tables={
        "routines": FeatureTable(
            "homebot.routines.tables:apps_of_routines",
            is_array=True,
            section="apps",
            plugin="homebot.routines.routine:Routine",
            check="homebot.routines.tables:check_routine",
        )
    },
)
