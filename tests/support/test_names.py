"""A name is the whole name; a similar one is asked about."""

import pytest

from homebot.errors import UsageError
from homebot.support.names import find_name, resolve_name

ROOMS = ("Küche", "The Den", "Living room")


@pytest.mark.parametrize(
    ("text", "name"),
    [
        *(("küche", "Küche"), ("kuche", "Küche"), ('"Küche"', "Küche"), ("the küche", "Küche")),
        *(("the den", "The Den"), ("den", ""), ("living-room", "Living room"), ("Kuch", ""), ("", "")),
    ],
)
def test_a_name_is_found_whatever_its_case_accents_and_quotes(text: str, name: str) -> None:
    assert find_name(text, ROOMS) == name


def test_a_similar_name_is_a_suggestion() -> None:
    with pytest.raises(UsageError, match=r"^there is no room 'Kuch'; did you mean Küche\?$"):
        resolve_name("room", "Kuch", ROOMS)
    with pytest.raises(UsageError, match=r"^there is no scene 'Film'; scenes are none$"):
        resolve_name("scene", "Film", ())
