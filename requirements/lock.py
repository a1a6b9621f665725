"""Locks the packages that are installed: ``make lock`` calls it.

Each file of this folder has the packages, with the hashes of their files, that a larger set adds to the smaller ones:
``run.txt`` for homebot itself, ``all.txt`` for its extra ``all``, ``dev.txt`` for checks, tests and documentation,
``peers.txt`` for the tests against other people's programs.
"""

import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
SETS = {"run": (), "all": ("all",), "dev": ("all", "dev", "docs"), "peers": ("all", "dev", "docs", "peers")}
BUILD = ("hatchling>=1.26", "editables>=0.5")
"""What builds homebot itself: installed before, so that the build downloads nothing."""

PYTHON = "3.11.2"
"""That of Debian 12: some packages refuse it by now, and a newer Python would lock them."""


def main() -> None:
    extras, pins = list(SETS.items()), HERE / "peers.txt"
    pins.write_text(resolved(extras[-1][1]))
    locked = blocks(pins.read_text())
    known: set[str] = set()
    for name, wanted in extras:
        needed = blocks(resolved(wanted, "--constraint", str(pins)))
        (HERE / f"{name}.new").write_text("".join(locked[one] for one in needed if one not in known))
        known |= needed.keys()
    for name, _ in extras:
        (HERE / f"{name}.new").replace(HERE / f"{name}.txt")


def resolved(extras: tuple[str, ...], *options: str) -> str:
    """Return the newest versions of homebot's packages with *extras*, with hashes."""
    uv = str(Path(sys.executable).with_name("uv"))
    command = [uv, "pip", "compile", "--quiet", "--no-header", "--no-annotate", "--generate-hashes", *options]
    command += ["--python-version", PYTHON, "--python-platform", "linux", "pyproject.toml", "-"]
    command += [word for extra in extras for word in ("--extra", extra)]
    return subprocess.run(
        command, cwd=HERE.parent, input="\n".join(BUILD), text=True, stdout=subprocess.PIPE, check=True
    ).stdout


def blocks(text: str) -> dict[str, str]:
    """Return the lines of each package by its name."""
    found = re.findall(r"^\S+==.*(?:\n    .*)*\n", text, re.MULTILINE)
    return {one.partition("==")[0]: one for one in found}


if __name__ == "__main__":
    main()
