"""Questions of the command line to ``/rosapi`` about the graph."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from homebot.cli.door_client import DoorClient
from homebot.cli.similar import not_found
from homebot.errors import PeerError

__all__ = ["WAITING", "GraphEntity", "entities", "no_such_topic", "topic_type"]

WAITING = "homebot: waiting for it; press Ctrl-C to stop"


class GraphEntity(BaseModel):
    """One node, or one end of a topic or service; fields as in ``homebot/msg/EndpointDetails``."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    kind: str
    node: str
    name: str
    type: str
    reliability: str
    durability: str
    history: str
    depth: int
    lifespan: float
    deadline: float
    liveliness: str
    liveliness_lease_duration: float

    @property
    def is_hidden(self) -> bool:
        """True if it is shown only on request."""
        return "/_" in self.name


class _Entities(BaseModel):
    endpoints: list[GraphEntity]


async def entities(door: DoorClient, *, kind: str = "", name: str = "", node: str = "") -> list[GraphEntity]:
    """Return what is on the graph, sorted by name; an empty text means any."""
    found = await door.call("/rosapi/endpoints", {"kind": kind, "name": name, "node": node})
    return _Entities.model_validate(found).endpoints


async def topic_type(door: DoorClient, topic: str) -> str:
    """Return what *topic* carries; empty where there is no such topic."""
    answer = await door.call("/rosapi/topic_type", {"topic": topic})
    return str(answer["type"])


async def no_such_topic(door: DoorClient, topic: str) -> PeerError:
    """Return the error that there is no *topic*; its message names similar ones."""
    known = [one.name for one in await entities(door) if one.kind in {"publisher", "subscription"}]
    return PeerError(not_found("topic", topic, known))
