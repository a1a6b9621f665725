"""State that all clients of a door share."""

from __future__ import annotations

from dataclasses import dataclass

from homebot.bridges.rosbridge.backlog import DoorBacklog
from homebot.bridges.rosbridge.client_error_log import ClientErrorLog
from homebot.bridges.rosbridge.counters import DoorCounters
from homebot.bridges.rosbridge.expected_topics import ExpectedTopics
from homebot.bridges.rosbridge.settings import DoorSettings
from homebot.bridges.rosbridge.turns import Turns
from homebot.graph import Node

__all__ = ["Common"]


@dataclass(frozen=True, slots=True)
class Common:
    """The state that all clients of a door share.

    Attributes:
        node: The node that acts in the clients' stead.
        settings: The limits.
        turns: When work may be done.
        backlog: What waits for all clients.
        expected: Topics to come.
        counters: What is counted.
        complaints: Where the log hears of what clients do wrong.
    """

    node: Node
    settings: DoorSettings
    turns: Turns
    backlog: DoorBacklog
    expected: ExpectedTopics
    counters: DoorCounters
    complaints: ClientErrorLog

    def held_by_all(self) -> int:
        """Return how many entities all clients together hold on the graph."""
        return self.node.graph.count_endpoints(self.node.full_name)
