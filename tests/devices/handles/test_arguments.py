"""What is asked of handles: what nobody knows is an error, never the whole house."""

import inspect
import string
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices import Devices, handles
from homebot.devices.handles import CommonFilters, DoorLock, Handle, Light, Thermostat
from homebot.graph import Graph, Node

_NAMED = [getattr(handles, name) for name in handles.__all__]
KINDS = [one for one in _NAMED if isinstance(one, type) and issubclass(one, Handle)]

UNKNOWN: dict[str, tuple[type[Any], dict[str, object], str]] = {
    "another word for a room": (Light, {"room": "Office"}, "Light cannot be filtered by 'room': did you mean area?"),
    "a misspelt area": (DoorLock, {"aera": "hall"}, "DoorLock cannot be filtered by 'aera': did you mean area?"),
    "a condition of another kind": (Light, {"is_locked": True}, "it takes area, category, colored, dimmable, fresh"),
    "a misspelt condition of its own": (Light, {"dimable": True}, "did you mean dimmable"),
    "an area that is no text": (Light, {"area": 3}, "area is a text, not 3"),
    "a word for a flag": (Light, {"on": "yes"}, "on_off is True or False, not 'yes'"),
    "a word for a number": (Thermostat, {"mode": 3}, "thermostat_mode is a text, not 3.0"),
    "a number for a flag": (Light, {"reachable": 1}, "reachable is True or False, not 1"),
}


@pytest.mark.parametrize(("kind", "asked", "problem"), UNKNOWN.values(), ids=UNKNOWN)
async def test_an_unknown_condition_is_an_error_that_suggests_the_nearest(
    kind: Any, asked: dict[str, object], problem: str
) -> None:
    async with Node(Graph(), "app") as node:
        devices = Devices(node)
        with pytest.raises(TypeError) as found:
            await devices.find(kind, **asked)
        with pytest.raises(TypeError) as followed:
            devices.follow(kind, **asked)
    assert problem in str(found.value)
    assert str(found.value) == str(followed.value)


async def test_an_unknown_category_is_an_error() -> None:
    category: Any = "settings"
    async with Node(Graph(), "app") as node:
        with pytest.raises(ValueError, match="category is 'config' or 'diagnostic', not 'settings'"):
            await Devices(node).find(Light, category=category)


@pytest.mark.parametrize(("extra", "conditions"), [((), {"area": "kitchen"}), (("kitchen",), {})])
async def test_a_word_of_a_type_takes_no_conditions(extra: tuple[str, ...], conditions: dict[str, str]) -> None:
    """They would be ignored, and every lamp of the house found."""
    problem = r"'lights' is a type name, which takes no filters \((area|'kitchen')\)"
    async with Node(Graph(), "app") as node:
        devices: Any = Devices(node)
        with pytest.raises(TypeError, match=problem):
            await devices.find("lights", *extra, **conditions)
        with pytest.raises(TypeError, match=problem):
            devices.follow("lights", *extra, **conditions)


@given(kind=st.sampled_from(KINDS), name=st.text(string.ascii_lowercase + "_", min_size=1, max_size=12))
def test_every_kind_refuses_every_word_that_it_does_not_take(kind: type[Handle], name: str) -> None:
    known = {*inspect.signature(kind.where).parameters, *CommonFilters.__annotations__} - {"filters"}
    if name in known:
        return
    arguments: dict[str, Any] = {name: True}
    with pytest.raises(TypeError, match=f"{kind.__name__} cannot be filtered by '{name}'"):
        kind.where(**arguments)
