"""How strongly several receivers hear a device, and the room which that suggests."""

import pytest

from homebot.conventions.bluetooth.hearing import MAX_RECEIVERS, Hearing, RoomGuess

ROOMS = {"k": "Kitchen", "b": "Bedroom", "s": "Kitchen"}


def heard(**signals: int) -> Hearing:
    hearing = Hearing()
    for receiver, rssi in signals.items():
        hearing.add(receiver, rssi, 0.0)
    return hearing


@pytest.mark.parametrize(
    ("signals", "guess"),
    [
        ({"k": -60, "b": -85}, RoomGuess("Kitchen", 1.0)),
        ({"k": -70, "b": -75}, RoomGuess("Kitchen", 0.7)),
        ({"b": -70, "k": -90, "s": -70}, RoomGuess("Bedroom", 0.5)),
        ({"b": -90}, RoomGuess("Bedroom", 0.8)),
        ({}, None),
    ],
)
def test_the_room_is_that_of_the_receiver_that_hears_it_best(signals: dict[str, int], guess: RoomGuess | None) -> None:
    """Rooms as strong as each other are as likely; one whose receiver hears nothing counts as -100 dBm."""
    found = heard(**signals).room(1.0, dict(sorted(ROOMS.items())))
    assert found == guess or (found is not None and guess is not None and found.certainty == guess.certainty == 0.5)


def test_a_single_room_with_receivers_suggests_nothing() -> None:
    assert heard(k=-40, s=-50).room(1.0, {"k": "Kitchen", "s": "Kitchen"}) is None


def test_silence_is_forgotten_and_receivers_are_bounded() -> None:
    hearing = heard(k=-60)
    assert hearing.strongest(1.0) == ("k", -60.0)
    assert hearing.strongest(60.0) is None
    for number in range(3 * MAX_RECEIVERS):
        hearing.add(str(number), -50, 60.0)
    assert len(hearing._signals) == MAX_RECEIVERS
