"""Extras: a missing library is one sentence that says how to install it."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.support.extras import check_extra


def test_nothing_is_said_where_all_is_installed() -> None:
    """The standard library is."""
    check_extra('the gateway "mdns"', "mdns", "json", "socket")


def test_a_missing_library_names_the_command_that_installs_it() -> None:
    """So that nobody has to look it up."""
    with pytest.raises(UsageError) as caught:
        check_extra('the gateway "mdns"', "mdns", "json", "no_such_library")
    assert str(caught.value) == 'the gateway "mdns" needs no_such_library; install it with: pip install "homebot[mdns]"'
