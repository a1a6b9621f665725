"""Alerts: people are told what is wrong in the house, once for each cause."""

from typing import Final

from homebot.feature import Feature, FeatureTable, Verb
from homebot.rights import OfferedService, Right

SEE_ALERTS: Final = OfferedService("/alerts/seen", Right.ACT)
TEST_ALERTS: Final = OfferedService("/alerts/test", Right.MANAGE)

FEATURE: Final = Feature(
    name="alerts",
    services=(SEE_ALERTS, TEST_ALERTS),
    runs="homebot.features.alerts.alerts:notify_people",
    is_wanted=lambda house: not house.is_rehearsal,
    checks="homebot.features.alerts.alert_table:doctor_checks",
    tables={"alerts": FeatureTable("homebot.features.alerts.alerts:read_alerts", is_on_page=True)},
    verbs={
        "seen": Verb(
            "say that the alerts were seen, so that nobody is told again",
            "homebot.features.alerts.command:add_arguments",
            after="doctor",
        )
    },
)
