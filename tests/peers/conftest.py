"""What tests against other people's programs share; see ``network.py`` for their networks."""

from collections.abc import Iterator

import pytest
from tests.peers.network import Lan, Machine, new_prefix, why_no_lan


@pytest.fixture(scope="session")
def _can_have_lans() -> None:
    problem = why_no_lan()
    if problem:
        pytest.skip(problem)


@pytest.fixture
def lan(_can_have_lans: None) -> Iterator[Lan]:
    """A network of the test's own."""
    lan = Lan(new_prefix())
    try:
        yield lan
    finally:
        lan.close()


@pytest.fixture
def hub(lan: Lan) -> Iterator[Machine]:
    """The machine on it that homebot runs on: all sockets of the test are there."""
    machine = lan.machine("hub")
    with machine.entered():
        yield machine
