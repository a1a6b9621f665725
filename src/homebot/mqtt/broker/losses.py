"""Losses of a broker, as text. No I/O."""

from __future__ import annotations

from collections import deque
from typing import Final, final

from homebot.mqtt.broker.stats import Counters

__all__ = ["LossReport", "loss_text"]

_TEXTS: Final = {
    "dropped_qos0": "of QoS 0 for clients that read too slowly",
    "dropped_offline": "for clients that were away too long",
    "dropped_overrun": "for clients that stayed too slow",
    "dropped_too_large": "too large for their clients",
    "retained_refused": "that were to be retained, for want of room",
}
"""What counts as a loss; an expired message, or one that a policy refused, does not."""

_KEPT: Final = 60

Losses = tuple[int, ...]


def loss_text(counters: Counters, before: Losses = ()) -> str:
    """Such as ``5 messages (3 of QoS 0 for clients that read too slowly, 2 too large for their clients)``.

    Args:
        counters: What was counted.
        before: The losses to leave out.

    Returns:
        The words; empty where nothing was lost.
    """
    old = before or (0,) * len(_TEXTS)
    news = {text: now - then for text, now, then in zip(_TEXTS.values(), _losses(counters), old, strict=True)}
    total = sum(news.values())
    if not total:
        return ""
    parts = ", ".join(f"{count} {words}" for words, count in news.items() if count)
    return f"{total} message{'s' if total > 1 else ''} ({parts})"


@final
class LossReport:
    """Tells what was lost since it was asked last, and lately: over the last sixty times that it was asked.

    Args:
        counters: What is counted.
    """

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._before: deque[Losses] = deque([_losses(counters)], maxlen=_KEPT)

    @property
    def lately(self) -> str:
        """Recent losses as text; empty where there are none."""
        return loss_text(self._counters, self._before[0])

    def take(self) -> str:
        """Return the losses since the last call as text; empty where there are none."""
        text = loss_text(self._counters, self._before[-1])
        self._before.append(_losses(self._counters))
        return text


def _losses(counters: Counters) -> Losses:
    return tuple(getattr(counters, name) for name in _TEXTS)
