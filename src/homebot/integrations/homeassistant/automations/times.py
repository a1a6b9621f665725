"""Times of day and days of the week of automations, as routines spell them. Pure."""

import re
from typing import Final

from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields

__all__ = ["clock_times", "days_text"]

_CLOCK: Final = re.compile(r"([01]?\d|2[0-3]):[0-5]\d(:[0-5]\d)?")
_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


def clock_times(fields: UnreadFields, key: str) -> list[str]:
    """Return the times of day of *key*, if it is there."""
    texts = fields.texts(key)
    for text in texts:
        if not _CLOCK.fullmatch(text):
            raise NotCarriedError(f"{key}: {text!r} is no time of day")
    return [text.removesuffix(":00") if text.count(":") > 1 else text for text in texts]


def days_text(fields: UnreadFields) -> str:
    """Return the days of the week as a condition, such as ``on mon,tue``; empty for none."""
    if "weekday" not in fields:
        return ""
    days = [one.casefold() for one in fields.texts("weekday")]
    if not days or any(one not in _DAYS for one in days):
        raise NotCarriedError(f"weekday: {', '.join(days) or 'nothing'} is no list of days such as mon, tue")
    return f"on {','.join(one for one in _DAYS if one in days)}"
