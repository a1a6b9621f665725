"""Names that people write, of a room, scene, routine or group. Pure.

A name is the whole name without regard to case and accents; a similar one is a suggestion, and never the answer.
"""

import re
from collections.abc import Iterable

from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean


def find_name(text: str, names: Iterable[str]) -> str:
    """Return the first of *names* that *text* is, perhaps in quotes or after ``the``; empty for none."""
    known: dict[str, str] = {}
    for name in names:
        known.setdefault(fold(name), name)
    plain = fold(text.strip('"'))
    return known.get(fold(text)) or known.get(plain) or known.get(plain.removeprefix("the "), "")


def resolve_name(kind: str, text: str, names: Iterable[str], otherwise: str = "") -> str:
    """Return the name by :func:`find_name`.

    Args:
        kind: What is named, such as ``room``.
        otherwise: The advice if none is similar; by default all are listed.

    Raises:
        UsageError: There is none; similar ones are suggested.
    """
    names = [*names]
    if name := find_name(text, names):
        return name
    raise UsageError(no_such(kind, text, names, otherwise))


def no_such(kind: str, text: str, names: Iterable[str], otherwise: str = "") -> str:
    """Return the error text for a name that nothing has; see :func:`resolve_name`."""
    known = [*dict.fromkeys(names)]
    hint = did_you_mean(text, known, otherwise or f"{kind}s are {', '.join(known) or 'none'}")
    return f"there is no {kind} {text!r}; {hint}"


def rename_scene(text: str, old: str, new: str) -> str:
    """Return the table *text* of a routine, with the scene *old* called *new* in the steps that apply it."""
    step = re.compile(rf"""(?P<quote>["'])scene\s+{re.escape(old)}(?=\s*(?:,|(?P=quote)))""", re.IGNORECASE)
    return step.sub(lambda found: f"{found['quote']}scene {new}", text)
