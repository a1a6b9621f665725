"""The layout of the thesis: words as they are, on ``HOME/SERVICE_TYPE/DEVICE_ID/out`` and ``…/in``."""

from __future__ import annotations

from collections.abc import Sequence

from homebot.house.condition import Condition
from homebot.house.dialect import Bridge, Nameplate, Outgoing
from homebot.house.kinds import KINDS

__all__ = ["ThesisDialect"]


class ThesisDialect:
    """Every kind of device; the layout announces none."""

    @property
    def kinds(self) -> frozenset[str]:
        """All."""
        return frozenset(KINDS)

    def filters(self, device: Nameplate) -> tuple[str, ...]:
        """Return its ``in``."""
        return (f"{_base(device)}/in",)

    def birth(self, device: Nameplate) -> tuple[Outgoing, ...]:
        """Return nothing."""
        del device
        return ()

    def will(self, device: Nameplate) -> Outgoing | None:
        """Return None."""
        del device
        return None

    def said(self, device: Nameplate, condition: Condition) -> tuple[Outgoing, ...]:
        """Return the word, on its ``out``; what is no Unicode becomes ``?``."""
        return (Outgoing(f"{_base(device)}/out", condition.word.encode(errors="replace")),)

    def told(self, device: Nameplate, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the payload as text; what is no UTF-8 becomes U+FFFD."""
        del device, topic
        return (payload.decode(errors="replace"),)

    def answers(self, device: Nameplate, condition: Condition, topic: str, payload: bytes) -> tuple[Outgoing, ...]:
        """Return nothing: nobody can ask."""
        del device, condition, topic, payload
        return ()

    def bridge(self, devices: Sequence[Nameplate]) -> Bridge | None:
        """Return None."""
        del devices
        return None


def _base(device: Nameplate) -> str:
    return f"{device.home}/{device.service_type}/{device.device_id}"
