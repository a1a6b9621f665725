"""How much the timeline of one part keeps."""

import pytest

from homebot.control.timeline.facts import Decided, Order, SendingEnded, Sent
from homebot.control.timeline.part_timeline import MAX_REPORTS, PartTimeline
from homebot.control.timeline.profile import DeviceProfile
from homebot.devices.outcomes import Confirmed, Evidence, NoAnswer, Outcome

LAMP_OF_INFRARED = {"on_off": True}


@pytest.mark.parametrize("outcome", [Confirmed(0.1, Evidence.ACKNOWLEDGED), NoAnswer(10.0)])
@pytest.mark.parametrize("seconds", [1.0, 60.0])
def test_a_part_that_never_reports_keeps_only_its_last_commands(seconds: float, outcome: Outcome) -> None:
    """All others would be kept for ever, and each further command compared with them."""
    timeline = PartTimeline(DeviceProfile(), first=10.0, settle=10.0)
    for number in range(5 * MAX_REPORTS):
        command(timeline, f"c-{number}", seconds * number, outcome)
    assert len(timeline.active) <= MAX_REPORTS + 1


def test_a_part_keeps_no_more_facts_after_days_than_after_an_hour() -> None:
    timeline = PartTimeline(DeviceProfile(), first=10.0, settle=10.0)
    kept = []
    for number in range(3 * 24 * 60):
        command(timeline, f"c-{number}", 60.0 * number, Confirmed(0.1, Evidence.REPORTED))
        timeline.report(60.0 * number + 30.0, 60.0 * number, "on_off", value=number % 2 == 0)
        timeline.advance(60.0 * number + 30.0)
        kept.append((len(timeline.sent), len(timeline.commands), len(timeline.reports)))
    assert [max(column) for column in zip(*kept[100:], strict=True)] == [
        max(column) for column in zip(*kept[:100], strict=True)
    ]


def command(timeline: PartTimeline, name: str, at: float, outcome: Outcome) -> None:
    """Give the command to turn it on, with its outcome a tenth of a second later."""
    timeline.command(Order(name, LAMP_OF_INFRARED, {}), at)
    for fact in (
        Sent(name, LAMP_OF_INFRARED, at),
        SendingEnded(name, at + 0.1),
        Decided(name, at + 0.1, outcome),
    ):
        timeline.append(fact)
