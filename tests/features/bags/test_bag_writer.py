"""Bags as rosbag2 makes them: files that rotate, in a folder that only its owner reads."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from pathlib import Path
from random import Random

import pytest
import yaml
from tests.features.bags.bags import CHAT, START, bag_of, whole, words

from homebot.errors import UsageError
from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.bag_writer import BagWriter


def write(writer: BagWriter, messages: Iterable[BagMessage]) -> None:
    with writer:
        for message in messages:
            writer.write(message)


def read(path: Path) -> list[list[BagMessage]]:
    return [list(file.messages()) for file in bag_files(path)]


@pytest.mark.parametrize("name", ["day", "day.mcap"])
def test_a_bag_has_what_was_written(tmp_path: Path, name: str) -> None:
    written = bag_of(tmp_path / name, 50)
    assert read(tmp_path / name) == [written]
    (file,) = bag_files(tmp_path / name)
    assert file.content() == ({CHAT: 50}, START, START + 4_900_000_000)


def test_only_its_owner_reads_it(tmp_path: Path) -> None:
    bag_of(tmp_path / "day", 1)
    modes = {one.relative_to(tmp_path).as_posix(): one.stat().st_mode & 0o777 for one in tmp_path.rglob("*")}
    assert modes == {"day": 0o700, "day/day_0.mcap": 0o600, "day/metadata.yaml": 0o600}


def test_the_next_file_begins_after_a_duration(tmp_path: Path) -> None:
    written = list(words(25))
    write(BagWriter(tmp_path / "day", max_duration=1.0), written)
    assert read(tmp_path / "day") == [written[:11], written[11:22], written[22:]]


def test_the_next_file_begins_after_a_size(tmp_path: Path) -> None:
    random = Random(1)  # noqa: S311 - the same each time
    written = [one._replace(data=random.randbytes(5_000)) for one in words(40)]
    write(BagWriter(tmp_path / "day", max_size=50_000), written)
    files = read(tmp_path / "day")
    assert list(chain.from_iterable(files)) == written
    assert all(10 <= len(file) <= 12 for file in files[:-1])


def test_the_metadata_of_a_folder_names_files_topics_and_times(tmp_path: Path) -> None:
    write(BagWriter(tmp_path / "day", max_duration=1.0, distribution="kilted"), words(15))
    (name, found), *_ = yaml.safe_load((tmp_path / "day/metadata.yaml").read_text()).items()
    topics = found.pop("topics_with_message_count")
    span = {"nanoseconds_since_epoch": START}, {"nanoseconds": 1_400_000_000}
    assert (name, found) == (
        "rosbag2_bagfile_information",
        {
            "version": 9,
            "storage_identifier": "mcap",
            "starting_time": span[0],
            "duration": span[1],
            "message_count": 15,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": ["day_0.mcap", "day_1.mcap"],
            "files": [
                {
                    "path": "day_0.mcap",
                    "starting_time": span[0],
                    "duration": {"nanoseconds": 1_000_000_000},
                    "message_count": 11,
                },
                {
                    "path": "day_1.mcap",
                    "starting_time": {"nanoseconds_since_epoch": START + 1_100_000_000},
                    "duration": {"nanoseconds": 300_000_000},
                    "message_count": 4,
                },
            ],
            "custom_data": None,
            "ros_distro": "kilted",
        },
    )
    (topic,) = topics
    assert topic["message_count"] == 15
    assert topic["topic_metadata"]["type_description_hash"] == CHAT.type_hash


def test_the_files_of_a_folder_are_read_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    """The tenth is before the second by name; and after a kill there is no metadata."""
    write(BagWriter(tmp_path / "day", max_duration=0.05), words(12))
    (tmp_path / "day/metadata.yaml").unlink()
    assert list(chain.from_iterable(read(tmp_path / "day"))) == list(words(12))


@pytest.mark.parametrize("qos", ["", "{", "[" * 100_000, "&a [*a]", "3"])
def test_the_quality_of_service_of_another_program_is_no_reason_to_fail(tmp_path: Path, qos: str) -> None:
    """It is copied from a bag that is recovered."""
    write(BagWriter(tmp_path / "day"), [one._replace(topic=replace(CHAT, qos=qos)) for one in words(1)])
    assert "version: 9" in (tmp_path / "day/metadata.yaml").read_text()


def test_one_file_has_no_limits(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"day.mcap is one file; name a folder, without .mcap"):
        BagWriter(tmp_path / "day.mcap", max_size=1000)
    assert not (tmp_path / "day.mcap").exists()


@pytest.mark.parametrize("name", ["day", "day.mcap"])
def test_nothing_is_replaced(tmp_path: Path, name: str) -> None:
    bag_of(tmp_path / name, 1)
    with pytest.raises(UsageError, match="exists already; delete it, or choose another name"):
        BagWriter(tmp_path / name)


def test_the_messages_of_more_than_ten_seconds_survive_a_kill(tmp_path: Path) -> None:
    """The writer is not closed; what came within the last seconds may be lost."""
    writer = BagWriter(tmp_path / "day")
    for message in words(150):
        writer.write(message)
    (file,) = bag_files(tmp_path / "day")
    assert whole(file) == list(words(101))
    writer.close()
