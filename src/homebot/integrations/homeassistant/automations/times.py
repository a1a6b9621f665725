"""Times of day and days of the week of automations, as routines spell them. Pure."""

import re
from typing import Final

from homebot.integrations.homeassistant.automations.fields import NotCarriedError, shown, text_of, texts_of
from homebot.support.located import Located

__all__ = ["clock_time", "days_text"]

_CLOCK: Final = re.compile(r"([01]?\d|2[0-3]):[0-5]\d(:[0-5]\d)?")
_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


def clock_time(node: Located, what: str) -> str:
    """Return a time of day."""
    text = text_of(node, what)
    if not _CLOCK.fullmatch(text):
        raise NotCarriedError(node.line, f"{what}: {shown(node)} is no time of day")
    return text.removesuffix(":00") if text.count(":") > 1 else text


def days_text(node: Located) -> str:
    """Return days of the week, such as ``mon,tue``."""
    days = [one.casefold() for one in texts_of(node, "weekday")]
    if not days or any(one not in _DAYS for one in days):
        raise NotCarriedError(node.line, f"weekday: {shown(node)} is no list of days such as mon, tue")
    return ",".join(one for one in _DAYS if one in days)
