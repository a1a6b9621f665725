"""Recording of topics of a running homebot into a bag, over the door."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from homebot.cli.graph_queries import entities, is_hidden, not_yet
from homebot.cli.remarks import remark
from homebot.cli.stop_signals import stop_signals
from homebot.devices.wording.json_message import fields_of
from homebot.errors import HomebotError, LinkError
from homebot.features.bags.bag_thread import BagThread
from homebot.features.bags.bag_topic import BagMessage, BagTopic, qos_text
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.public_message import without_raw_secrets
from homebot.support.name_patterns import fits_any

if TYPE_CHECKING:
    from homebot.bridges.rosapi.endpoints import EndpointDetails
    from homebot.cli.door_client import DoorClient

_LOOK_EVERY: Final = 0.25
"""Seconds between two looks for new topics."""

_ALL: Final = ("/**",)


def record(door: DoorClient, options: argparse.Namespace) -> int:
    """Record until a stop signal, the end of the time, or an error, which is raised once all else is written."""
    path = Path(options.output or f"rosbag2_{datetime.now().astimezone():%Y_%m_%d-%H_%M_%S}")
    distribution = str(door.call("/rosapi/get_ros_version")["distro"])
    writer = BagWriter(path, options.max_size, options.max_duration, distribution)
    problem: HomebotError | None = None
    with stop_signals() as stopped, BagThread(writer) as bag:
        recorder = _Recorder(door, bag, options.topics or _ALL, options.exclude)
        try:
            recorder.run(math.inf if options.seconds is None else time.monotonic() + options.seconds, stopped)
        except LinkError as exc:
            problem = exc
    dropped = recorder.lost + bag.dropped
    lost = f"; {dropped:,} messages were lost" if dropped else ""
    print(f"{path}: {writer.count:,} messages; topics: {len(recorder.topics):,}{lost}")
    if (problem := problem or bag.error) is not None:
        raise problem
    return 0


@final
class _Recorder:
    """Reads the topics that fit *wanted* and not *unwanted*, also those that come later.

    Attributes:
        lost: Messages that the door dropped.
    """

    def __init__(self, door: DoorClient, bag: BagThread, wanted: Sequence[str], unwanted: Sequence[str]) -> None:
        self.topics: dict[str, BagTopic] = {}
        self.lost = 0
        self._door, self._bag = door, bag
        self._wanted, self._unwanted = wanted, unwanted

    def run(self, ends: float, stopped: Sequence[int]) -> None:
        """Record until the monotonic time *ends*, or something is in *stopped*."""
        self._follow_new_topics()
        if not self.topics:
            remark(not_yet(self._door, " ".join(self._wanted)), as_json=False)
        while not stopped and not self._bag.error and (left := ends - time.monotonic()) > 0:
            for received in self._door.until(min(_LOOK_EVERY, left)):
                self.lost += received.lost
                fields: Mapping[str, Any] = received.message
                at = fields["secs"] * 1_000_000_000 + fields["nsecs"]
                self._bag.put(without_raw_secrets(BagMessage(self.topics[received.topic], at, fields["bytes"])))
            self._follow_new_topics()

    def _follow_new_topics(self) -> None:
        offered: dict[str, list[EndpointDetails]] = {}
        for endpoint in entities(self._door, kind="publisher"):
            if endpoint.name not in self.topics and self._is_wanted(endpoint):
                offered.setdefault(endpoint.name, []).append(endpoint)
        if not offered:
            return
        known: Mapping[str, Any] = self._door.call("/rosapi/topics_and_raw_types")
        texts = dict(zip(known["topics"], known["typedefs_full_text"], strict=True))
        for name, ends in offered.items():
            if name in texts:  # else its publisher has just left
                qos = qos_text(map(fields_of, ends))
                self.topics[name] = BagTopic.of(name, ends[0].type, texts[name], qos)
                self._door.subscribe(name, "cbor-raw")

    def _is_wanted(self, end: EndpointDetails) -> bool:
        return not is_hidden(end) and fits_any(end.name, self._wanted) and not fits_any(end.name, self._unwanted)
