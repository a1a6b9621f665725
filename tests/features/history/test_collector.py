"""What is collected for the history."""

from homebot.clock import ManualClock
from homebot.devices.device import StateChange
from homebot.devices.value import Reading, Value
from homebot.features.history.collector import Collector
from homebot.messages import Time


def test_a_value_ends_once_however_often_it_is_told() -> None:
    """A house that stops says so, and so does the node that keeps its history."""
    clock = ManualClock()
    collector = Collector(clock, 10, {}, {})
    reading = Reading(part="", capability="temperature", value=Value.of(21.5))
    now = Time.from_seconds(clock.now())
    collector.on_values(StateChange(stream="", device="hall", readings=(reading,), told_at=now, live=True, sequence=1))
    clock.advance(60.0)
    collector.close()
    clock.advance(0.01)
    collector.close()
    assert len(collector.batch.times) == 2
