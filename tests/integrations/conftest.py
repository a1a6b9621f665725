"""Generated cases and networks for the ``fuzz`` and the ``peers`` of integrations."""

from tests.fuzz.conftest import fuzz
from tests.peers.conftest import _can_have_lans, hub, lan

__all__ = ["_can_have_lans", "fuzz", "hub", "lan"]
