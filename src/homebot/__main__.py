"""``python -m homebot``."""

from __future__ import annotations

import sys

from homebot.cli import main

__all__: list[str] = []

if __name__ == "__main__":
    sys.exit(main())
