"""Distance by the strength of a signal, and how long a device may be silent."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.bluetooth.signal import DISTANCE_FACTOR, Presence, SignalFilter, distance_of


@pytest.mark.parametrize(
    ("rssi", "metres"), [(-59, 1.0), (-87, 10.0), (-31, 0.1), (-73, 3.2), (-127, 100.0), (20, 0.1)]
)
def test_a_distance_follows_the_path_loss(rssi: float, metres: float) -> None:
    """28 dB are ten times as far."""
    assert distance_of(rssi, -59) == pytest.approx(metres, rel=0.06) or metres == distance_of(rssi, -59)


def test_the_uncertainty_is_a_factor_of_about_two() -> None:
    assert pytest.approx(1.93, abs=0.01) == DISTANCE_FACTOR


@given(st.floats(-120, 0), st.floats(-100, 0))
def test_a_weaker_signal_is_never_nearer(rssi: float, near: float) -> None:
    assert distance_of(rssi - 5, near) >= distance_of(rssi, near)


def test_one_strong_packet_does_not_change_the_signal() -> None:
    signal = SignalFilter()
    for second, rssi in enumerate((-70, -71, -30, -69, -70)):
        signal.add(rssi, second)
    assert signal.value(5) == -70


def test_old_packets_and_unknown_values_do_not_count() -> None:
    signal = SignalFilter()
    signal.add(-50, 0)
    signal.add(127, 20)
    assert signal.value(20) == -50
    assert signal.value(31) is None


def presence(*times: float) -> Presence:
    found = Presence(0.0)
    for one in times:
        found.record(one)
    return found


def test_a_device_may_be_silent_for_half_a_minute() -> None:
    assert presence(0.1, 0.2, 1.3).stale_after(0) == 30


def test_a_rare_advertiser_may_be_silent_for_three_intervals() -> None:
    assert presence(60, 120, 180).stale_after(0) == 300


def test_one_absence_does_not_count() -> None:
    assert presence(10, 20, 2000, 2010).stale_after(0) == 30


def test_copies_of_a_packet_do_not_make_an_interval() -> None:
    assert presence(0.3, 0.6, 60, 60.3, 60.6, 120, 120.3).stale_after(0) == 300


def test_a_longer_silence_that_is_declared_counts() -> None:
    assert presence(1, 2, 3).stale_after(86_400) == 86_400
