"""Why a connection could not be made, as people read it."""

import errno
import socket

import pytest

from homebot.support.connect_errors import connect_problem


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (
            ConnectionRefusedError(errno.ECONNREFUSED, "Connect call failed ('127.0.0.1', 19511)"),
            "nothing is listening there (connection refused): start it, or correct the address",
        ),
        (OSError(errno.EHOSTUNREACH, "Connect call failed ('10.0.0.9', 1883)"), "no route to that host"),
        (OSError(errno.ENETUNREACH, "Connect call failed ('::2', 1883, 0, 0)"), "no route to that network"),
        (PermissionError(errno.EACCES, "Connect call failed ('10.0.0.9', 1883)"), "Permission denied"),
        (
            socket.gaierror(socket.EAI_NONAME, "Name or service not known"),
            "the host name is unknown: correct the address",
        ),
        (
            socket.gaierror(socket.EAI_AGAIN, "Temporary failure in name resolution"),
            "the host name cannot be looked up now (Temporary failure in name resolution)",
        ),
        (OSError("the host name has no address"), "the host name has no address"),
        (TimeoutError(), "TimeoutError"),
    ],
)
def test_the_reason_is_plain_and_without_the_address(error: OSError, expected: str) -> None:
    assert connect_problem(error) == expected
