"""Addresses and secrets as the page shows them: by the scheme and the end, as they contain passwords. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Final

from homebot.errors import UsageError

_HIDDEN: Final = "…"
_SHOWN: Final = 2
"""Characters at the end by which two addresses of one kind differ."""


def shown(value: object, secrets: Collection[str] = ()) -> object:
    """Return *value* with its addresses and *secrets* as they are shown, no two alike."""
    names = {own: name for name, own in _shown_names(value, secrets).items()}
    return _each(value, names)


def stated(value: object, kept: object, secrets: Collection[str] = ()) -> object:
    """Return *value* with the addresses and *secrets* of *kept* in place of their shown forms.

    Raises:
        UsageError: An address is the shown form of none in *kept*.
    """
    names = _shown_names(kept, secrets)
    for text in _texts(value):
        if f"://{_HIDDEN}" in text and text not in names:
            raise UsageError(f"the address {text[:100]!r} is not in the file any more; look at it again")
    return _each(value, names)


def hidden_in(lines: Sequence[str], value: object, secrets: Collection[str] = ()) -> list[str]:
    """Return *lines* with the addresses of *value*, and the *secrets*, as they are shown."""
    text = "\n".join(lines)
    names = _shown_names([value, *secrets], secrets).items()
    for name, own in sorted(names, key=lambda pair: -len(pair[1])):  # one may begin with another
        text = text.replace(own, name)
    return text.splitlines()


def _shown_names(value: object, secrets: Collection[str]) -> dict[str, str]:
    """Return the addresses and *secrets* in *value* by their shown forms."""
    found: dict[str, str] = {}
    for text in dict.fromkeys(_texts(value)):
        scheme, colon, rest = text.partition("://")
        if colon or text in secrets:
            end = rest[-_SHOWN:] if len(rest) > 4 * _SHOWN else ""
            name = f"{scheme}://{_HIDDEN}{end}" if colon else _HIDDEN
            same = sum(one.partition(" ")[0] == name for one in found)
            found[f"{name} ({same + 1})" if same else name] = text
    return found


def _texts(value: object) -> Iterator[str]:
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texts(inner)
    if isinstance(value, str):
        yield value


def _each(value: object, names: dict[str, str]) -> object:
    if isinstance(value, dict):
        return {key: _each(inner, names) for key, inner in value.items()}
    if isinstance(value, list):
        return [_each(inner, names) for inner in value]
    return names.get(value, value) if isinstance(value, str) else value
