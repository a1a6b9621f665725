from dataclasses import dataclass

import pytest

from homebot.conventions.description import Availability, AvailabilityMode
from homebot.gateways.announced.announcement import SharedReachability


@dataclass(frozen=True)
class Word:
    topic: str

    def read(self, payload: bytes) -> bool | None:
        return bool(payload)


def reachability(mode: AvailabilityMode) -> SharedReachability:
    return SharedReachability(Availability((Word("a"), Word("b")), mode))


@pytest.mark.parametrize(
    ("mode", "words", "meaning"),
    [
        ("all", [], None),
        ("all", [(0, True)], None),
        ("all", [(0, True), (1, True)], True),
        ("all", [(0, False)], False),
        ("any", [(0, False)], None),
        ("any", [(0, False), (1, False)], False),
        ("any", [(0, True)], True),
        ("latest", [(0, False), (1, True)], True),
        ("latest", [(0, True), (1, False)], False),
        ("latest", [], None),
    ],
)
def test_the_words_are_joined_by_the_mode(
    mode: AvailabilityMode,
    words: list[tuple[int, bool]],
    meaning: bool | None,  # noqa: FBT001 - a parameter of the test
) -> None:
    known = reachability(mode)
    for index, said in words:
        known.update(index, said, retained=False)
    assert known.value is meaning


@pytest.mark.parametrize("mode", ["all", "any", "latest"])
def test_a_sign_of_life_makes_a_kept_no_unknown_and_no_live_one(mode: AvailabilityMode) -> None:
    known = reachability(mode)
    known.update(0, False, retained=True)
    known.update(1, False, retained=True)
    known.discard_retained_offline()
    assert known.value is None
    known.update(0, False, retained=False)
    known.update(1, False, retained=False)
    known.discard_retained_offline()
    assert known.value is False
