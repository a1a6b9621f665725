"""Bags on the command line without a running homebot: their content, their repair, and recordings as bags."""

import argparse
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

from homebot.features.bags.bag_files import bag_files
from homebot.features.bags.bag_topic import BagTopic
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.mcap_file import DamagedFileError
from homebot.features.bags.public_message import without_raw_secrets
from homebot.features.bags.recorded_messages import recorded_messages
from homebot.recording.recording import load_recording
from homebot.support.printable import printable


def info(options: argparse.Namespace) -> int:
    """Print the content of a bag like ``ros2 bag info``."""
    files = bag_files(Path(options.bag))
    contents = [file.content() for file in files]
    used = [content for content in contents if sum(content.counts.values())]
    start, end = min((content.start for content in used), default=0), max((content.end for content in used), default=0)
    counts: Counter[BagTopic] = sum((Counter(content.counts) for content in contents), Counter())
    print(f"Files:             {', '.join(file.path.name for file in files)}")
    print(f"Bag size:          {sum(file.path.stat().st_size for file in files) / 1024:,.1f} KiB")
    print("Storage id:        mcap")
    print(f"Duration:          {(end - start) / 1e9:.3f} s")
    print(f"Start:             {_time(start)}")
    print(f"End:               {_time(end)}")
    print(f"Messages:          {counts.total():,}")
    for topic, count in sorted(counts.items(), key=lambda counted: counted[0].name):
        print(f"Topic:             {printable(topic.name)} | {printable(topic.ros_type)} | {count:,}")
    return 0


def recover(options: argparse.Namespace) -> int:
    """Copy the whole messages of a bag, and say if there are others."""
    files = bag_files(Path(options.bag))
    with BagWriter(Path(options.new)) as writer:
        for file in files:
            before = writer.count
            what = "messages, all that it has"
            try:
                for message in file.whole_messages():
                    writer.write(message)
            except DamagedFileError:
                what = "messages; others are cut off or damaged"
            print(f"{file.path}: {writer.count - before:,} {what}")
    return 0


def export(options: argparse.Namespace) -> int:
    """Write a recording of homebot as a bag."""
    recording = load_recording(Path(options.recording))
    with BagWriter(Path(options.new)) as writer:
        for message in recorded_messages(recording):
            writer.write(without_raw_secrets(message))
    print(f"{options.new}: {writer.count:,} messages")
    return 0


def _time(nanoseconds: int) -> str:
    return f"{datetime.fromtimestamp(nanoseconds / 1e9, UTC).astimezone():%Y-%m-%d %H:%M:%S} ({nanoseconds / 1e9:.3f})"
