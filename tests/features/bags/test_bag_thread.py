"""A bag that is written in a thread: nobody waits for the disk, and what is lost is counted."""

import struct
from pathlib import Path

from tests.features.bags.bags import words

from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_thread import BagThread
from homebot.features.bags.bag_writer import BagWriter


def test_what_is_put_is_written_before_the_end(tmp_path: Path) -> None:
    with BagThread(BagWriter(tmp_path / "day")) as bag:
        for message in words(1000):
            bag.put(message)
    (file,) = bag_files(tmp_path / "day")
    assert bag.dropped == 0
    assert list(file.messages()) == list(words(1000))


def test_messages_that_do_not_fit_are_dropped_and_counted(tmp_path: Path) -> None:
    """The thread begins when they are there already."""
    bag = BagThread(BagWriter(tmp_path / "day"), most_bytes=1000)
    for message in words(10):
        bag.put(message)
    with bag:
        pass
    (file,) = bag_files(tmp_path / "day")
    assert bag.dropped == 6
    assert list(file.messages()) == list(words(4))


def test_after_an_error_of_the_disk_everything_is_dropped(tmp_path: Path) -> None:
    """The folder for the next file is gone."""
    bag = BagThread(BagWriter(tmp_path / "day", max_duration=0.05))
    (tmp_path / "day").rename(tmp_path / "gone")
    messages = list(words(3))
    for message in messages:
        bag.put(message)
    with bag:
        pass
    assert bag.dropped == 2
    assert "day ends early: " in str(bag.error)
    assert "day_1.mcap cannot be written: No such file or directory; `homebot bag recover " in str(bag.error)
    bag.put(messages[0])
    assert bag.dropped == 3


def test_an_unexpected_error_ends_the_bag_and_is_told(tmp_path: Path) -> None:
    """A time that no bag can hold."""
    first, second, third = words(3)
    with BagThread(BagWriter(tmp_path / "day")) as bag:
        for message in (first, second._replace(at=-1), third):
            bag.put(message)
    assert bag.dropped == 2
    assert "day ends early: error: " in str(bag.error)
    assert bag.error is not None
    assert isinstance(bag.error.__cause__, struct.error)
