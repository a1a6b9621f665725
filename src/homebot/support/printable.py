"""Sanitizing of outside texts for one line of a terminal. Pure."""

_WIDEST = 200


def printable(text: str, widest: int = _WIDEST) -> str:
    """Return *text* with control characters escaped, cut to *widest* characters."""
    signs = text[: widest + 1]
    shown = "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in signs)
    return shown if len(shown) <= widest else f"{shown[: widest - 1]}…"
