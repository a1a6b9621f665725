"""Names of secrets: PIN codes, passwords, keys and tokens, which are never read. Pure.

They must not appear in reports of devices or in recordings.
"""

import re


def names_secret(name: str) -> bool:
    """Return whether *name* is that of a code, password or key: ``pin_code``, ``User code``."""
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
"""``PIN`` only in capitals: ``pin`` and ``PIN 4`` may be pins of a chip."""
