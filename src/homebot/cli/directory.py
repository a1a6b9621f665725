"""Questions of the command line to ``/rosapi`` about the graph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

from homebot.cli.door_client import DoorClient
from homebot.cli.records import EntityRecord
from homebot.errors import PeerError
from homebot.similar import did_you_mean

__all__ = ["entities", "is_hidden", "no_such_topic", "not_found", "not_yet", "topic_type"]


def entities(door: DoorClient, *, kind: str = "", name: str = "", node: str = "") -> list[EntityRecord]:
    """Return what is on the graph, sorted by name; an empty text means any."""
    found = door.call("/rosapi/endpoints", {"kind": kind, "name": name, "node": node})
    return cast("list[EntityRecord]", found["endpoints"])


def is_hidden(entity: EntityRecord) -> bool:
    """Return whether *entity* is shown only on request."""
    return "/_" in entity["name"]


def topic_type(door: DoorClient, topic: str) -> str:
    """Return what *topic* carries; empty where there is no such topic."""
    return str(door.call("/rosapi/topic_type", {"topic": topic})["type"])


def no_such_topic(door: DoorClient, topic: str) -> PeerError:
    """Return the error that there is no *topic*; its message names similar ones."""
    known = [one["name"] for one in entities(door) if one["kind"] in {"publisher", "subscription"}]
    return not_found("topic", topic, known)


def not_yet(door: DoorClient, topic: str) -> str:
    """Return the line that says that *topic*, which does not exist, is waited for; it names similar ones."""
    known = [one["name"] for one in entities(door) if one["kind"] in {"publisher", "subscription"}]
    similar = did_you_mean(topic, known, "", cutoff=0.7)
    return f"homebot: no topic {topic} yet; waiting, Ctrl-C stops" + (f" ({similar})" if similar else "")


def not_found(kind: str, name: str, known: Iterable[str]) -> PeerError:
    """Return the error that there is no *kind* called *name*; its message names similar ones of the *known*."""
    return PeerError(f"there is no {kind} {name}; {did_you_mean(name, known, f'`homebot {kind} list` lists all')}")
