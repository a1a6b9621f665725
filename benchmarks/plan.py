"""How much to measure, and with what peers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from worker import Worker

__all__ = ["Plan"]


@dataclass(frozen=True, slots=True)
class Plan:
    """What every benchmark is given.

    Attributes:
        quick: A short look with few rounds, instead of the real thing.
        home_assistant: The process that measures Home Assistant, or None where it is not installed.
        home_assistant_python: The Python that has it installed, or None.
        mosquitto: Path of the broker program, or None where it is not installed.
    """

    quick: bool
    home_assistant: Worker | None
    mosquitto: str | None
    home_assistant_python: Path | None = None

    def rounds(self, normal: int) -> int:
        return min(normal, 2) if self.quick else normal

    def count(self, normal: int) -> int:
        return max(1, normal // 20) if self.quick else normal

    def ask_home_assistant(self, job: str, **facts: str | int) -> float:
        """Return how many deliveries or calls a second it made."""
        assert self.home_assistant is not None
        self.home_assistant.start(job, **facts)
        return float(self.home_assistant.result()["per_second"])
