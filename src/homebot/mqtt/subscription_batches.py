"""Which subscriptions are asked for together. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from homebot.mqtt.client import MqttSubscription

__all__ = ["batches"]

MOST = 100
MOST_CHARACTERS = 16_384


def batches(subscriptions: Iterable[MqttSubscription]) -> Iterator[tuple[MqttSubscription, ...]]:
    """Yield *subscriptions* in their order, those together that one request may make.

    A filter with a wildcard stands alone, because a broker sends all the messages that it keeps for it at once, and
    so does one of QoS 1 or 2. Of the others, with at most one kept message each, up to 100 are one batch.
    """
    batch: list[MqttSubscription] = []
    size = 0
    for one in subscriptions:
        is_single = one.qos > 0 or "+" in one.filter or "#" in one.filter
        size += len(one.filter)
        if batch and (is_single or len(batch) >= MOST or size > MOST_CHARACTERS):
            yield tuple(batch)
            batch, size = [], len(one.filter)
        if is_single:
            yield (one,)
        else:
            batch.append(one)
    if batch:
        yield tuple(batch)
