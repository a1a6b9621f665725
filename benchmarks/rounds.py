"""Measures contenders side by side: in each round all of them, one after the other, so that a slow moment of the
machine hits everybody."""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable, Mapping
from typing import TypeAlias

__all__ = ["Samples", "measure_interleaved", "median"]

Measure: TypeAlias = Callable[[], float]
Samples: TypeAlias = dict[str, list[float]]


def measure_interleaved(contenders: Mapping[str, Measure], rounds: int) -> Samples:
    """Return *rounds* figures of each contender by name.

    One more round goes before them, to warm up, and is thrown away. Every second round runs in reverse order.
    """
    samples: Samples = {name: [] for name in contenders}
    for number in range(rounds + 1):
        names = list(contenders)
        for name in reversed(names) if number % 2 else names:
            gc.collect()
            figure = contenders[name]()
            if number > 0:
                samples[name].append(figure)
    return samples


def median(figures: list[float]) -> float:
    return statistics.median(figures)
