"""What is collected for the history."""

from tests.call_counts import calls

from homebot.clock import ManualClock
from homebot.devices.device import ChangeKind, Device, DeviceChange, StateChange
from homebot.devices.value import Reading, Value
from homebot.features.history.batch import Place, Series
from homebot.features.history.collector import Collector
from homebot.messages import Time


class Collected:
    """A collector, and devices that tell it one value."""

    def __init__(self, most: int, known: dict[Place, Series] | None = None) -> None:
        self.clock = ManualClock()
        self.collector = Collector(self.clock, most, known or {}, {})

    def tell(self, device: str, value: float, capability: str = "temperature") -> None:
        self.clock.advance(60.0)
        readings = (Reading(part="", capability=capability, value=Value.of(value)),)
        now = Time.from_seconds(self.clock.now())
        change = StateChange(stream="", device=device, readings=readings, told_at=now, live=True, sequence=1)
        self.collector.on_values(change)

    def change(self, device: str, kind: ChangeKind) -> None:
        now = Time.from_seconds(self.clock.now())
        described = Device(
            id=device,
            name=device,
            service_type="temperature_sensor",
            endpoints=(),
            metadata=(),
            first_seen=now,
            last_seen=now,
            expires=now,
            freshness="fresh",
        )
        self.collector.on_device(DeviceChange(kind=kind, device=described, sequence=1, why=""))


def test_a_value_ends_once_however_often_it_is_told() -> None:
    """A house that stops says so, and so does the node that keeps its history."""
    house = Collected(10)
    house.tell("hall", 21.5)
    house.clock.advance(60.0)
    house.collector.close()
    house.clock.advance(0.01)
    house.collector.close()
    assert len(house.collector.batch.times) == 2


def test_a_removed_device_makes_room_for_another() -> None:
    """As what comes and goes by Bluetooth: its place was taken until the next start."""
    house = Collected(2)
    for number in range(10):
        house.change(f"tag{number}", "appeared")
        house.tell(f"tag{number}", 20.0)
        house.change(f"tag{number}", "removed")
    assert (len(house.collector.series), house.collector.left_out) == (10, 0)
    for device in ("hall", "attic", "cellar"):
        house.tell(device, 20.0)
    assert house.collector.left_out == 1
    assert house.collector._followed.keys() == {"hall", "attic"}


def test_a_counter_that_was_removed_goes_on_when_it_is_back() -> None:
    house = Collected(10)
    house.tell("meter", 100.0, "energy")
    house.change("meter", "removed")
    house.tell("meter", 103.0, "energy")
    assert list(house.collector.batch.values) == [100.0, 100.0, 103.0]


def test_a_correction_of_a_counter_that_was_not_seen_in_this_run_holds() -> None:
    """Its last value came from the file as it was before."""
    place = ("meter", "", "energy")
    house = Collected(10, {place: Series(7, place, "kWh")})
    house.collector.restart_total(7, 50.0)
    house.tell("meter", 52.0, "energy")
    assert list(house.collector.batch.values) == [50.0, 52.0]


def test_a_new_series_costs_the_same_however_many_there_are() -> None:
    places = [(f"sensor{number}", "", "temperature") for number in range(5000)]
    few, many = Collected(10), Collected(10, {place: Series(number, place, "") for number, place in enumerate(places)})
    few.tell("hall", 20.0)
    many.tell("hall", 20.0)
    assert calls(lambda: many.tell("attic", 20.0)) == calls(lambda: few.tell("attic", 20.0))
