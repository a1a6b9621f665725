"""Patterns of names on the graph."""

import pytest

from homebot.support.name_patterns import fits_any


@pytest.mark.parametrize(
    ("name", "pattern", "fits"),
    [
        ("/map", "/map", True),
        ("/map/a", "/map", False),
        ("/rosie/a/b", "/rosie/**", True),
        ("/rosie/a/b", "/rosie/*", False),
        ("/rosie/a", "/rosie/*", True),
        ("/rosieother/a", "/rosie/**", False),
        ("/rosie/left_cam/image", "/rosie/*_cam/image", True),
    ],
)
def test_a_star_is_within_one_part_of_a_name(name: str, pattern: str, *, fits: bool) -> None:
    assert fits_any(name, (pattern,)) is fits
