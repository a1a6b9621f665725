"""Witnesses: sensors that see whether a commanded device did what it reports."""

from homebot.control.witnesses.verification import WitnessVerification

__all__ = ["WitnessVerification"]
