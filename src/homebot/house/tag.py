"""A tag for a reader."""

from dataclasses import dataclass, field
from typing import ClassVar, Final

from homebot.house.simulated_device import SimulatedDevice

AWAY: Final = "away"


@dataclass(eq=False)
class SimulatedTag(SimulatedDevice):
    """A tag: ``tap`` holds it to a reader, which reads its text, for a while; then it is ``away`` again.

    Attributes:
        text: The text on it: the id or the name of a device; by default its own name.
        hold: Seconds at the reader, above 0.
        every: Seconds between automatic taps; 0 for none.
    """

    kind: ClassVar[str] = "tag"
    by_hand = ("tap",)
    text: str = ""
    hold: float = 2.0
    every: float = 0.0
    service_type: str = field(default="tags", kw_only=True)

    def __post_init__(self) -> None:
        self.text = self.text or self.device_id
        self._leaves_at: float | None = None
        self._tapped_at = self.now

    def state(self) -> str:
        """Return the text while it is at the reader, else ``away``."""
        return AWAY if self._leaves_at is None else self.text

    def next_event(self) -> float | None:
        """Return when it leaves the reader, or is next tapped automatically."""
        if self._leaves_at is not None:
            return self._leaves_at
        return self._tapped_at + max(self.every, self.hold) if self.every else None

    def _obey(self, command: str) -> tuple[str, ...]:
        return self._tap() if command == "tap" else ()

    def _on_timer(self) -> tuple[str, ...]:
        if self._leaves_at is None:
            return self._tap()
        self._leaves_at = None
        return (AWAY,)

    def _tap(self) -> tuple[str, ...]:
        is_there = self._leaves_at is not None
        self._tapped_at = self.now
        self._leaves_at = self.now + self.hold
        return () if is_there else (self.text,)
