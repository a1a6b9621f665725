"""Counters of the door since it opened."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["DoorCounters"]


@dataclass(slots=True)
class DoorCounters:
    """Numbers that only grow.

    Attributes:
        clients: Clients that were let in.
        turned_away: Connections that were not: too many, a foreign page, a wrong token.
        wrong_tokens: Tokens that were not the right one.
        frames: Frames that clients sent.
        requests_refused: Of those, what was refused.
        slowed_down: Frames that had to wait because their client sends too many.
        clients_cut: Clients cut off because they took no bytes.
    """

    clients: int = 0
    turned_away: int = 0
    wrong_tokens: int = 0
    frames: int = 0
    requests_refused: int = 0
    slowed_down: int = 0
    clients_cut: int = 0
