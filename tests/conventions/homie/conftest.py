import json
from collections.abc import Callable

import pytest
from tests.conventions.announced_parts import device_in

from homebot.conventions.description import AnnouncementEvent, DescribedPart
from homebot.conventions.homie import Homie, HomieSettings

Say = Callable[..., tuple[AnnouncementEvent, ...]]


@pytest.fixture
def homie() -> Homie:
    return Homie(HomieSettings())


@pytest.fixture
def say(homie: Homie) -> Say:
    """Return a function that reads a message; a payload that is no text is spelled in JSON."""

    def say(topic: str, payload: object) -> tuple[AnnouncementEvent, ...]:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        return homie.read_message(topic, text.encode(), retained=True)

    return say


@pytest.fixture
def introduce(say: Say) -> Callable[..., dict[str, DescribedPart]]:
    """Return a function that announces a device of version 5, perhaps anew, and returns its parts by id."""

    def introduce(nodes: object, **fields: object) -> dict[str, DescribedPart]:
        said = say("homie/5/thing/$description", {"homie": "5.0", "version": 1, "nodes": nodes, **fields})
        device = device_in((*said, *say("homie/5/thing/$state", "ready")))
        return {one.part.id: one for one in device.parts}

    return introduce
