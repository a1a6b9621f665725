"""People: who is at home, as devices, and the household of all."""

from typing import Final

from homebot.feature import Feature, FeatureTable

FEATURE: Final = Feature(
    name="people",
    tables={
        "people": FeatureTable(
            "homebot.features.people.settings:gateway_of_people",
            is_on_page=True,
            section="gateways",
            plugin="homebot.features.people.people_gateway:PeopleGateway",
            implied_by="knows_people",
        )
    },
)
