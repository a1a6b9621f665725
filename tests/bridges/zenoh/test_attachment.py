"""The attachments of messages of ROS 2 on Zenoh."""

import pytest

from homebot.bridges.zenoh.attachment import Attachment
from homebot.errors import TypeMismatchError

FIRST = Attachment(1, 1_700_000_000_000_000_000, bytes(range(16)))
BYTES = bytes.fromhex("0100000000000000 00002a36fe9c9717 10 000102030405060708090a0b0c0d0e0f")
OLD = (
    b"\x0fsequence_number" + BYTES[:8] + b"\x10source_timestamp" + BYTES[8:16] + b"\x0asource_gid" + BYTES[16:]
)  # fmt: skip


def test_it_has_the_bytes_of_rmw_zenoh() -> None:
    assert FIRST.to_bytes() == BYTES
    assert Attachment.of_bytes(BYTES) == FIRST


def test_that_of_jazzy_before_2025_is_read() -> None:
    assert len(OLD) == 77
    assert Attachment.of_bytes(OLD) == FIRST


@pytest.mark.parametrize(
    "data", [b"", BYTES[:-1], BYTES + b"\x00", BYTES[:16] + b"\x11" + BYTES[17:], OLD.replace(b"gid", b"uid")]
)
def test_another_form_is_refused_in_words(data: bytes) -> None:
    with pytest.raises(TypeMismatchError, match=rf"{len(data)} bytes beside a message .* is its sender rmw_zenoh"):
        Attachment.of_bytes(data)
