"""Each gateway and each driver can be read in an afternoon; decision 28 says what is counted."""

import pytest
from tests.source_trees import SOURCE

from homebot.plugins import own_plugin_names, plugin_path

MAX_LINES = 1450
OWN_LIMITS = {"homebot.gateways.mqtt": 2700}
"""Decision 28 has the reason."""


def plugin_packages() -> list[str]:
    """Return the package of each gateway and driver of homebot itself."""
    groups = ("homebot.gateways", "homebot.drivers")
    return sorted(plugin_path(group, name).partition(":")[0] for group in groups for name in own_plugin_names(group))


def size_of(package: str) -> int:
    """Return the number of lines of *package*, which may be one file, docstrings and empty lines included."""
    path = SOURCE.parent / package.replace(".", "/")
    files = list(path.rglob("*.py")) or [path.with_suffix(".py")]
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


@pytest.mark.parametrize("package", plugin_packages())
def test_each_gateway_and_each_driver_is_smaller_than_its_limit(package: str) -> None:
    assert size_of(package) < OWN_LIMITS.get(package, MAX_LINES)


def test_no_package_is_counted_with_another() -> None:
    packages = plugin_packages()
    assert len(set(packages)) == len(packages) >= 5
    assert not [one for one in packages for other in packages if one.startswith(f"{other}.")]
