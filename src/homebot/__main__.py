"""``python -m homebot``."""

import os
import sys

if sys.path and sys.path[0] in {"", os.getcwd()}:  # noqa: PTH109 - other imports could come from this folder
    del sys.path[0]  # ``python -m`` searches it first: a file in the working directory would shadow an installed module

from homebot.cli import main

if __name__ == "__main__":
    sys.exit(main())
