"""``make help`` lists what can be made, and its packages can be installed."""

import re
import subprocess
import tomllib
from importlib.metadata import distributions
from pathlib import Path

from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).parent.parent

_DEBIAN_12 = "3.11.2"
"""The Python that comes with it."""


def test_help_has_a_line_for_every_target() -> None:
    phony = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert phony is not None
    shown = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True, timeout=120).stdout
    assert re.findall(r"^  make (\S+) +[A-Zh].*\.$", shown, re.MULTILINE) == phony[1].split()


def test_each_locked_package_can_be_installed_with_the_python_of_debian_12() -> None:
    texts = [one.read_text() for one in (ROOT / "requirements").glob("*.txt")]
    locked = dict(re.findall(r"^(\S+)==(\S+) \\$", "".join(texts), re.MULTILINE))
    needs = {
        (re.sub(r"[-_.]+", "-", one.name).lower(), one.version): one.metadata["Requires-Python"] or ""
        for one in distributions()
    }
    found = {package: needs[package] for package in locked.items() if package in needs}
    assert len(found) > len(locked) / 2
    assert [package for package, need in found.items() if not SpecifierSet(need).contains(_DEBIAN_12)] == []


def test_every_locked_package_has_the_hashes_of_its_files() -> None:
    for file in (ROOT / "requirements").glob("*.txt"):
        blocks = re.split(r"^(?=\S)", file.read_text(), flags=re.MULTILINE)[1:]
        assert [
            one for one in blocks if not re.fullmatch(r"\S+==\S+( ; .+)?( \\\n    --hash=sha256:[0-9a-f]{64})+\n", one)
        ] == []


def test_the_newest_packages_of_each_extra_are_used_by_a_test() -> None:
    """``make test-newest`` runs those that are marked, slow and of peers."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"].keys()
    tests = "".join(one.read_text() for one in (ROOT / "tests").rglob("test_*.py"))
    marked = re.findall(r"^@pytest\.mark\.newest\(\"([a-z0-9-]+)\"\)$", tests, re.MULTILINE)
    assert sorted(marked) == sorted(extras - {"all", "dev", "docs", "peers", "testing"})
