"""Quantities, each with its unit and bounds, once for the whole project."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

__all__ = ["Bytes", "Port", "Seconds"]

Seconds = Annotated[float, Field(gt=0, allow_inf_nan=False, description="seconds")]
Bytes = Annotated[int, Field(gt=0, description="bytes")]
Port = Annotated[int, Field(ge=0, le=65_535, description="TCP port; 0 is any free one")]
