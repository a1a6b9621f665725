"""Bags of homebot, read by mcap-ros2-support, the library of Foxglove."""

from pathlib import Path
from typing import Any

import pytest
from tests.features.bags.test_judges import write_golden

from homebot.features.bags.bag_files import bag_files
from homebot.messages.cdr import message_from_cdr
from homebot.messages.definition import fields_of
from homebot.messages.message import Message
from homebot.messages.numeric_array import NumericArray

reader: Any = pytest.importorskip("mcap_ros2.reader")


def agrees(ours: object, theirs: Any) -> bool:
    if isinstance(ours, Message):
        names = [field.name for field in fields_of(type(ours))]
        return all(agrees(getattr(ours, name), getattr(theirs, name)) for name in names)
    if isinstance(ours, tuple | NumericArray | bytes):
        return len(ours) == len(theirs) and all(map(agrees, ours, theirs))
    return bool(ours == theirs)


@pytest.mark.newest("mcap")
def test_every_message_is_decoded(tmp_path: Path) -> None:
    written = write_golden(tmp_path / "golden.mcap")
    (file,) = bag_files(tmp_path / "golden.mcap")
    ours = [message_from_cdr(one.topic.message_type(), one.data) for one in file.messages()]
    theirs = [one.ros_msg for one in reader.read_ros2_messages(tmp_path / "golden.mcap")]
    assert len(theirs) == len(written)
    assert [type(mine).__name__ for mine, other in zip(ours, theirs, strict=True) if not agrees(mine, other)] == []
