from dataclasses import dataclass

import pytest

from homebot.gateways.mqtt.description import Availability, AvailabilityMode
from homebot.gateways.mqtt.reachability import Reachability


@dataclass(frozen=True)
class Word:
    topic: str

    def read(self, payload: bytes) -> bool | None:
        return {b"on": True, b"off": False}.get(payload)


def reachability(mode: AvailabilityMode) -> Reachability:
    return Reachability(Availability((Word("a"), Word("b")), mode))


@pytest.mark.parametrize(
    ("mode", "words", "meaning"),
    [
        ("all", [], None),
        ("all", [(0, b"on")], None),
        ("all", [(0, b"on"), (1, b"on")], True),
        ("all", [(0, b"off")], False),
        ("any", [(0, b"off")], None),
        ("any", [(0, b"off"), (1, b"off")], False),
        ("any", [(0, b"on")], True),
        ("latest", [(0, b"off"), (1, b"on")], True),
        ("latest", [(0, b"on"), (1, b"off"), (0, b"what")], False),
        ("latest", [(0, b"what")], None),
    ],
)
def test_the_words_are_joined_by_the_mode(
    mode: AvailabilityMode,
    words: list[tuple[int, bytes]],
    meaning: bool | None,  # noqa: FBT001 - a parameter of the test
) -> None:
    known = reachability(mode)
    for index, payload in words:
        known.hear(index, payload, retained=False)
    assert known.value is meaning


@pytest.mark.parametrize("mode", ["all", "any", "latest"])
def test_a_sign_of_life_makes_a_kept_no_unknown_and_no_live_one(mode: AvailabilityMode) -> None:
    known = reachability(mode)
    known.hear(0, b"off", retained=True)
    known.hear(1, b"off", retained=True)
    known.doubt()
    assert known.value is None
    known.hear(0, b"off", retained=False)
    known.hear(1, b"off", retained=False)
    known.doubt()
    assert known.value is False
