"""Names of what opens a lock or a network: PIN codes, passwords, keys and tokens, which are never read. Pure.

Whoever may see what devices report, or a recording of it, is not to learn them.
"""

from __future__ import annotations

import re

__all__ = ["names_secret"]


def names_secret(name: str) -> bool:
    """Return whether *name*, a key or in words, is that of a code, password or key: ``pin_code``, ``User code``."""
    return _SECRETS.search(name) is not None


_OPENED = "door|entry|gate|guest|keypad|lock|master|unlock|user"
_WORDS = "|".join(
    [
        rf"(?:access|action|admin|disarm|setup|{_OPENED})[_\W]code(?!r)",
        rf"(?:{_OPENED})[_\W]pin(?![^\W_]|[_\W]mode)",
        r"(?:access|api|auth|refresh)[_\W](?:key|token)(?![^\W_])",
        r"(?:bind|network|wpa)[_\W]?key(?![^\W_])",
        r"wi[_\W]?fi[_\W]qr(?![^\W_])",
        r"(?-i:PIN)(?![^\W_]|\W\d)",
    ]
)
_SECRETS = re.compile(rf"pin[_\W]?code|pass(?:word|code|phrase)|wifi[_\W]config|(?<![^\W_])(?:{_WORDS})", re.IGNORECASE)
"""``PIN`` in capitals alone: a ``pin`` may be one of a chip, and so may ``PIN 4``."""
