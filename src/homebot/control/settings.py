"""Settings of the control layer."""

from __future__ import annotations

from pydantic import Field

from homebot.control.policies import PolicySettings
from homebot.units import Seconds

__all__ = ["ControlSettings"]


class ControlSettings(PolicySettings):
    """The table ``[control]``, with that of the policies.

    Attributes:
        timeout: Seconds that a device has for its answer, until its usual time is known.
        retries: How often a command without an answer is sent again. Momentary ones, such as a press, never are.
        settle: Seconds after a confirmed command in which a device that goes back is reported as reverted.
        hand_time: Seconds for which a person's hand outranks a lease.
        journal_days: Days for which the journal keeps what happened.
        journal_megabytes: Size of the journal's file at most; the oldest entries are dropped first.
    """

    timeout: Seconds = 10.0
    retries: int = Field(default=2, ge=0, le=10)
    settle: Seconds = 10.0
    hand_time: Seconds = 300.0
    journal_days: float = Field(default=30.0, gt=0, le=3660)
    journal_megabytes: float = Field(default=50.0, ge=1, le=10_000)
