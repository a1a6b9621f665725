"""Writing of a bag: one MCAP file, or a folder as rosbag2 makes it, whose files rotate.

Source: rosbag2, ``sequential_writer.cpp`` and ``metadata_io.cpp`` (version 9).
"""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, Self, final

import yaml

from homebot.errors import UsageError
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.mcap_file import CHUNK, McapWriter
from homebot.support.new_file import create_file, explain_create_error

_FLUSHED_EVERY: Final = 10_000_000_000
"""Nanoseconds of messages that a power cut may cost."""


@final
class BagWriter:
    """A new bag, readable by its owner only.

    Args:
        path: One file if its name ends in ``.mcap``; else a folder.
        max_size: Bytes after which the next file begins; 0 for no limit.
        max_duration: Seconds, likewise.
        distribution: The distribution of ROS 2 that has the types.

    Attributes:
        count: Messages in it.

    Raises:
        UsageError: It cannot be written, or exists already; or one file cannot have a limit.
    """

    def __init__(self, path: Path, max_size: int = 0, max_duration: float = 0.0, distribution: str = "jazzy") -> None:
        self.path, self.count = path, 0
        self._max_size, self._max_duration = max_size, round(max_duration * 1e9)
        self._distribution = distribution
        self._flushed_at = 0
        self._is_folder = path.suffix != ".mcap"
        if self._is_folder:
            with explain_create_error(path):
                path.mkdir(mode=0o700)
        elif max_size or max_duration:
            raise UsageError(f"{path} is one file; name a folder, without .mcap, for files of limited size or duration")
        self._files = [self._next_file(0)]

    def write(self, message: BagMessage) -> None:
        """Add *message*; begin the next file first if the limit is reached.

        Raises:
            OSError: The disk is full or missing.
            UsageError: The next file cannot be written.
        """
        file = self._files[-1]
        if self._is_full(file, message.at):
            metadata, full = self._metadata(), file
            file = self._next_file(len(self._files))
            self._files.append(file)
            full.close(_text(metadata["rosbag2_bagfile_information"]))
        file.write(message)
        self.count += 1
        if not 0 <= message.at - self._flushed_at < _FLUSHED_EVERY:
            self._flushed_at = message.at
            file.flush()

    def flush(self) -> None:
        """Give everything to the operating system."""
        self._files[-1].flush()

    def close(self) -> None:
        """Write the index, and the metadata of a folder."""
        metadata = self._metadata()
        self._files[-1].close(_text(metadata["rosbag2_bagfile_information"]))
        if self._is_folder:
            with create_file(self.path / "metadata.yaml") as file:
                file.write(_text(metadata).encode())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _is_full(self, file: McapWriter, at: int) -> bool:
        if not file.counts:
            return False
        is_long = bool(self._max_duration) and at - file.start > self._max_duration
        return is_long or 0 < self._max_size <= file.size

    def _next_file(self, number: int) -> McapWriter:
        file = create_file(self.path / f"{self.path.name}_{number}.mcap" if self._is_folder else self.path)
        return McapWriter(file, min(CHUNK, self._max_size // 10 or CHUNK))

    def _metadata(self) -> dict[str, Any]:
        counts = sum((file.counts for file in self._files), Counter())
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            **_span(self._files),
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic.name,
                        "type": topic.ros_type,
                        "serialization_format": topic.encodings[0],
                        "offered_qos_profiles": _profiles(topic.qos),
                        "type_description_hash": topic.type_hash,
                    },
                    "message_count": count,
                }
                for topic, count in counts.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file.name for file in self._files],
            "files": [{"path": file.name, **_span([file])} for file in self._files],
            "custom_data": None,
            "ros_distro": self._distribution,
        }
        return {"rosbag2_bagfile_information": information}


def _span(files: Sequence[McapWriter]) -> dict[str, Any]:
    used = [file for file in files if file.counts]
    start, end = min((file.start for file in used), default=0), max((file.end for file in used), default=0)
    return {
        "starting_time": {"nanoseconds_since_epoch": start},
        "duration": {"nanoseconds": end - start},
        "message_count": sum(file.counts.total() for file in files),
    }


def _profiles(qos: str) -> Any:
    try:
        return yaml.safe_load(qos or "[]")
    except (yaml.YAMLError, RecursionError):  # of another program
        return []


def _text(metadata: dict[str, Any]) -> str:
    return yaml.safe_dump(metadata, sort_keys=False)
