"""Networks for the peers of machines."""

from tests.peers.conftest import _can_have_lans, hub, lan

__all__ = ["_can_have_lans", "hub", "lan"]
