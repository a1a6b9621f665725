"""What a topic of a bag says of its messages."""

from dataclasses import replace

import pytest
from tests.features.bags.bags import topic

from homebot.graph import qos_profile_latched


@pytest.mark.parametrize(
    ("qos", "is_latched"),
    [
        (topic("/any", qos=qos_profile_latched).qos, True),
        (topic("/any").qos, False),
        ("- history: keep_last\n  depth: 1\n  reliability: reliable\n  durability: transient_local\n", True),
        ("- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 2147483647\n", True),
        ("- history: 1\n  depth: 1\n  reliability: 1\n  durability: 2\n  deadline:\n    sec: 1\n", False),
        ("", False),
    ],
)
def test_it_is_latched_as_each_version_of_ros_2_writes_it(qos: str, *, is_latched: bool) -> None:
    assert replace(topic("/any"), qos=qos).is_latched == is_latched
