"""The skips that the nightly run may have, each with why; any other fails it, as it hides what is not tested."""

from collections.abc import Iterable
from typing import Final

import pytest
from tests.sizes import NIGHTLY

ALLOWED: Final = {
    "this machine has no IPv6": "a container may have none",
    "this computer has no address": "it is offline, and the test has a twin on loopback",
    "reads /proc": "only Linux has it",
    "Linux": "what other systems lack",
    "/proc counts the bytes": "only Linux has it",
    "each system has its own place": "there is one test for each system",
    "others have no D-Bus": "it is for Linux",
    "no podman or docker": "the image that it begins with comes from a registry; its commands are checked",
    "only root": "and others run the rest",
    "Mosquitto's file of rules cannot refuse a subscription": "the contract is that of other brokers",
    "needs Python": "the peer is for a Python that this computer lacks",
}
"""Part of the reason of a skip, and why that hides nothing."""


def hidden(reasons: Iterable[str]) -> list[str]:
    """Return the *reasons* that are not allowed, each once."""
    return [one for one in dict.fromkeys(reasons) if not any(part in one for part in ALLOWED)]


def _hidden_in(config: pytest.Config) -> list[str]:
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    reports = reporter.stats.get("skipped", []) if NIGHTLY and reporter is not None else []
    return hidden(one.longrepr[2] for one in reports if isinstance(one.longrepr, tuple))


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Let the nightly run fail for a skip that hides."""
    if session.exitstatus == pytest.ExitCode.OK and _hidden_in(session.config):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List them."""
    for reason in _hidden_in(terminalreporter.config):
        terminalreporter.write_line(f"a skip that hides (tests/skips.py lists those that may): {reason}", red=True)
