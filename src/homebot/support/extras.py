"""Libraries that are installed by an extra of homebot, such as ``homebot[mdns]``."""

from __future__ import annotations

import importlib.util

from homebot.errors import UsageError

__all__ = ["check_extra"]


def check_extra(what: str, extra: str, *modules: str) -> None:
    """Check that the libraries of an extra are installed; none is imported.

    Args:
        what: The feature, as text: ``the gateway "mdns"``.

    Raises:
        UsageError: One is missing; names the command that installs it.
    """
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        raise UsageError(f'{what} needs {", ".join(missing)}; install it with: pip install "homebot[{extra}]"')
