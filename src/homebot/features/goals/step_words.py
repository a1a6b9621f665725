"""Steps of plans in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.features.goals.messages import PlannedStep


def step_text(step: PlannedStep) -> str:
    """Return a step of the plan for a goal, why it asks first, and its outcome."""
    asks = f" (asks first: {step.asks})" if step.asks else ""
    return printable(f"{step.text}{asks}{f': {step.outcome}' if step.outcome else ''}", 1000)
