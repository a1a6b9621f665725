from collections.abc import Callable

import pytest
from tests.integrations.announced_parts import Say, device_in, spoken_to

from homebot.conventions.description import DescribedPart
from homebot.integrations.homie.formats import Homie, HomieSettings


@pytest.fixture
def homie() -> Homie:
    return Homie(HomieSettings())


@pytest.fixture
def say(homie: Homie) -> Say:
    return spoken_to(homie)


@pytest.fixture
def introduce(say: Say) -> Callable[..., dict[str, DescribedPart]]:
    """Return a function that announces a device of version 5, perhaps anew, and returns its parts by id."""

    def introduce(nodes: object, **fields: object) -> dict[str, DescribedPart]:
        said = say("homie/5/thing/$description", {"homie": "5.0", "version": 1, "nodes": nodes, **fields})
        device = device_in((*said, *say("homie/5/thing/$state", "ready")))
        return {one.part.id: one for one in device.parts}

    return introduce
