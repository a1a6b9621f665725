"""People by the answers of their phones, in virtual time."""

import anyio
import pytest
from tests.gateways.watched_gateway import watched

from homebot.devices.gateway_messages import Report
from homebot.devices.value import PlainValue
from homebot.features.people.people_gateway import PeopleGateway
from homebot.features.people.settings import PeopleSettings
from homebot.graph import Node

pytestmark = pytest.mark.virtual_time

SETTINGS = PeopleSettings.model_validate({"people": {"Anna": {"ping": "10.0.0.2", "away_after": 1200.0}}})


class Phone:
    """Answers, or does not; None is a house without a network."""

    answer: bool | None = True

    async def ping(self, _address: str) -> bool | None:
        return self.answer


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (False, {60: True, 180: None, 1_200: None, 1_350: False}),
        (None, {60: None, 180: None, 1_200: None, 1_350: None}),
    ],
)
async def test_a_phone_that_sleeps_is_not_away_at_once(answer: bool | None, told: dict[float, PlainValue]) -> None:  # noqa: FBT001
    """And one that cannot be asked is never away."""
    phone = Phone()

    def make(node: Node) -> PeopleGateway:
        return PeopleGateway(node, SETTINGS, ping=phone.ping)

    async with watched("people", make) as (gateway, watcher):
        values: dict[str, PlainValue] = {}

        def on_report(report: Report) -> None:
            values.update({one.capability: one.value.plain() for one in report.readings})

        watcher.create_subscription(Report, gateway.names.readings, on_report)
        await anyio.sleep(5)
        assert values["at_home"] is True
        phone.answer, found, at = answer, {}, 5.0
        for after in told:
            await anyio.sleep(after - at)
            at, found[after] = after, values["at_home"]
        assert found == told
