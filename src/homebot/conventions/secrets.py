"""Names of what opens a lock or a network: PIN codes and passwords, which are never read. Pure.

Whoever may see what devices report, or a recording of it, is not to learn them.
"""

from __future__ import annotations

import re

__all__ = ["names_secret"]


def names_secret(name: str) -> bool:
    """Return whether *name*, a key or in words, is that of a code or password: ``pin_code``, ``User code``."""
    return _SECRETS.search(name) is not None


_SECRETS = re.compile(
    r"pin[_\W]?code|pass(?:word|code|phrase)|wifi[_\W]config|(?<![^\W_])(?:action|admin|user)[_\W]code(?!r)",
    re.IGNORECASE,
)
