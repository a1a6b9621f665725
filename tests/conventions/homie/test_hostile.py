"""Any message and any value: only WireError from announcements, RefusedError from commands, nothing from states."""

import contextlib

import pytest

from homebot.conventions.homie import Homie, HomieSettings
from homebot.errors import WireError

pytestmark = pytest.mark.slow


def test_long_and_deep_messages_cost_little() -> None:
    homie = Homie(HomieSettings())
    for payload in (b"[" * 100_000, b"{" * 5_000_000, b'{"homie":"5.0","nodes":' + b'{"a":' * 10_000):
        for topic in ("homie/5/x/$description", "homie/x/$nodes"):
            with contextlib.suppress(WireError):
                assert homie.read_message(topic, payload, retained=True) == ()
