"""Coordinate frames over time, with the names, rules and error texts of tf2. Pure.

Source: geometry2 0.39.1, ``tf2/src/buffer_core.cpp`` and ``time_cache.cpp``.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right, insort
from dataclasses import dataclass, field
from operator import attrgetter
from typing import NamedTuple, final

from homebot.errors import HomebotError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from homebot.messages.std_msgs.header import Header
from homebot.places.rigid import IDENTITY, Rigid

__all__ = [
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "TransformBuffer",
    "TransformException",
]

CACHE_TIME = 10_000_000_000
"""Nanoseconds for which transforms are kept, before the newest one of the frame."""

MAX_FRAMES = 1000
MAX_SAMPLES = 10_000
"""Transforms kept of one frame; the oldest is dropped for a newer one."""

_NORM_TOLERANCE = 0.01
_LATEST = 0


class TransformException(HomebotError):
    """A transform cannot be given, or is refused."""


class LookupException(TransformException):
    """A frame does not exist."""


class ConnectivityException(TransformException):
    """Two frames are not part of one tree."""


class ExtrapolationException(TransformException):
    """The transform at the wanted time would have to be guessed."""


class InvalidArgumentException(TransformException):
    """The name of a frame or a transform is invalid."""


class _Sample(NamedTuple):
    """A transform of a frame at a time, in nanoseconds."""

    stamp: int
    parent: str
    rigid: Rigid


_stamp = attrgetter("stamp")


@dataclass(slots=True)
class _Track:
    """The transforms of one frame, by time; of a static frame one, which holds at any time."""

    is_static: bool
    samples: list[_Sample] = field(default_factory=list)

    @property
    def newest(self) -> _Sample:
        return self.samples[-1]

    def at(self, time: int) -> _Sample:
        """Return the transform at *time*, the newest for 0, one between two that have the same parent.

        Raises:
            ExtrapolationException: The time is outside the track.
        """
        if self.is_static or time == _LATEST:
            return self.newest
        first, last = self.samples[0].stamp, self.newest.stamp
        if not first <= time <= last:
            raise ExtrapolationException(_outside(time, first, last))
        index = bisect_left(self.samples, time, key=_stamp)
        later, earlier = self.samples[index], self.samples[max(0, index - 1)]
        if later.stamp == time:
            return later
        if earlier.parent != later.parent:
            return earlier
        share = (time - earlier.stamp) / (later.stamp - earlier.stamp)
        return _Sample(time, earlier.parent, earlier.rigid.between(later.rigid, share))

    def add(self, sample: _Sample) -> bool:
        """Insert *sample* in the order of time; return False for one that is too old."""
        if self.is_static:
            self.samples = [sample]
        elif self.samples and sample.stamp < self.newest.stamp - CACHE_TIME:
            return False
        elif not self.samples or sample.stamp > self.newest.stamp:
            self.samples.append(sample)
            oldest = bisect_right(self.samples, sample.stamp - CACHE_TIME - 1, key=_stamp)
            del self.samples[: max(oldest, len(self.samples) - MAX_SAMPLES)]
        elif sample not in self.samples[bisect_left(self.samples, sample.stamp, key=_stamp) :]:
            insort(self.samples, sample, key=_stamp)
        return True


@final
class TransformBuffer:
    """The frames of one robot or house, and the transforms between them."""

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}
        self._frames: dict[str, None] = {}

    def set_transform(self, transform: TransformStamped, authority: str = "") -> bool:
        """Insert *transform*; return False for one that is too old.

        Args:
            authority: The sender, for errors.

        Raises:
            InvalidArgumentException: A frame name is empty, a frame is its own ancestor, a number is not finite, the
                quaternion is not of length 1, or there are too many frames.
        """
        header = transform.header
        return self.put(transform, header.frame_id, transform.child_frame_id, header.stamp, authority)

    def set_transform_static(self, transform: TransformStamped, authority: str = "") -> bool:
        """Insert *transform*, which holds at any time; see :meth:`set_transform`."""
        header = transform.header
        return self.put(transform, header.frame_id, transform.child_frame_id, header.stamp, authority, is_static=True)

    def lookup_transform(self, target_frame: str, source_frame: str, time: Time | None = None) -> TransformStamped:
        """Return the transform that maps points of *source_frame* into *target_frame*.

        Args:
            time: The time; None or zero for the latest at which all frames between them are known.

        Raises:
            InvalidArgumentException: A frame name is empty or begins with a slash.
            LookupException: A frame does not exist.
            ConnectivityException: The frames are not part of one tree.
            ExtrapolationException: The transform is not known at that time.
        """
        asked = {"target_frame": target_frame, "source_frame": source_frame}
        for argument, frame in asked.items():
            if not frame or frame.startswith("/"):
                problem = "start with a '/'" if frame else "be empty"
                invalid = f'Invalid argument "{frame}" passed to lookupTransform argument {argument}'
                raise InvalidArgumentException(f"{invalid} - in tf2 frame_ids cannot {problem}")
        at = _LATEST if time is None else _nanoseconds(time)
        if target_frame == source_frame:
            track = self._tracks.get(source_frame)
            latest = 0 if track is None or track.is_static else track.newest.stamp
            return _stamped(target_frame, source_frame, at or latest, IDENTITY)
        for argument, frame in asked.items():
            if frame not in self._frames:
                raise LookupException(f'"{frame}" passed to lookupTransform argument {argument} does not exist. ')
        at = at or self._latest_common(target_frame, source_frame)
        return _stamped(target_frame, source_frame, at, self.rigid(target_frame, source_frame, at))

    def can_transform(self, target_frame: str, source_frame: str, time: Time | None = None) -> bool:
        """Return whether :meth:`lookup_transform` gives one."""
        try:
            self.lookup_transform(target_frame, source_frame, time)
        except TransformException:
            return False
        return True

    def ancestors(self, frame: str) -> list[str]:
        """Return *frame* and its ancestors by the newest transforms."""
        return [*self._walk(frame, _LATEST)[0]]

    def clear(self) -> None:
        """Forget all transforms but static ones."""
        self._tracks = {name: track for name, track in self._tracks.items() if track.is_static}

    def put(
        self, transform: TransformStamped, parent: str, child: str, at: Time, authority: str, *, is_static: bool = False
    ) -> bool:
        """Insert *transform* under other names of its frames, or at another time; see :meth:`set_transform`."""
        parent, child = parent.removeprefix("/"), child.removeprefix("/")
        moved, turned = transform.transform.translation, transform.transform.rotation
        rigid = Rigid((moved.x, moved.y, moved.z), (turned.x, turned.y, turned.z, turned.w))
        if problem := self._problem(parent, child, rigid):
            sender = f" from {authority}" if authority else ""
            raise InvalidArgumentException(f"the transform{sender} from {child[:100]!r} to {parent[:100]!r} {problem}")
        track = self._tracks.get(child, _Track(is_static))
        if track.is_static is not is_static:
            track = _Track(is_static)
        if not track.add(_Sample(_nanoseconds(at), parent, rigid)):
            return False
        self._tracks[child] = track
        self._frames.update({parent: None, child: None})
        return True

    def _problem(self, parent: str, child: str, rigid: Rigid) -> str:
        numbers = (*rigid.translation, *rigid.rotation)
        if not parent or not child:
            return "lacks the name of a frame"
        if parent == child:
            return "has the same frame at both ends"
        if not all(map(math.isfinite, numbers)):
            return "has a number that is not finite"
        if abs(sum(one * one for one in rigid.rotation) - 1) >= _NORM_TOLERANCE:
            return f"has a quaternion that is not of length 1: {rigid.rotation}"
        if child in self.ancestors(parent):
            return "would make the frame its own ancestor"
        if len(self._frames.keys() | {parent, child}) > MAX_FRAMES:
            return f"is of one frame more than {MAX_FRAMES:,}"
        return ""

    def _latest_common(self, target: str, source: str) -> int:
        """Return the newest time at which all transforms between two frames are known; 0 if all are static.

        Raises:
            ConnectivityException: The frames are not part of one tree.
        """
        above_target, above_source = set(self.ancestors(target)), set(self.ancestors(source))
        if above_target.isdisjoint(above_source):
            raise _unconnected(target, source)
        tracks = (self._tracks[one] for one in above_target ^ above_source)
        return min((track.newest.stamp for track in tracks if track.newest.stamp and not track.is_static), default=0)

    def rigid(self, target: str, source: str, time: int = _LATEST) -> Rigid:
        """Return the transform of points of *source* into *target*, by default by the newest transforms.

        Raises:
            ExtrapolationException: A transform on the way is not known at that time.
            ConnectivityException: The frames are not part of one tree at that time.
        """
        up, first_problem = self._walk(source, time)
        down, problem = self._walk(target, time)
        for frame, way in down.items():
            if frame in up:
                return way.inverse().then(up[frame])
        if problem := problem or first_problem:
            where = f", when looking up transform from frame [{source}] to frame [{target}]"
            raise ExtrapolationException(f"{problem}{where}")
        raise _unconnected(target, source)

    def _walk(self, frame: str, time: int) -> tuple[dict[str, Rigid], str]:
        """Return *frame* and its ancestors at *time*, each with the transform of points of the frame into it.

        With them is the reason for which there are no more; it is empty for the root.
        """
        walked = {frame: IDENTITY}
        while (track := self._tracks.get(frame)) is not None:
            try:
                sample = track.at(time)
            except ExtrapolationException as exc:
                return walked, str(exc)
            if sample.parent in walked:  # at an older time frames may have stood in a circle
                raise LookupException(f"The tf tree is invalid because it contains a loop at frame [{sample.parent}]")
            walked[sample.parent] = sample.rigid.then(walked[frame])
            frame = sample.parent
        return walked, ""


def _unconnected(target: str, source: str) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target}' and '{source}' because they are not part of the same tree."
        f"Tf has two or more unconnected trees."
    )


def _outside(time: int, first: int, last: int) -> str:
    """Return the error text for a *time* before *first* or after *last*."""
    begin = "Lookup would require extrapolation"
    if first == last:
        return f"{begin} at time {_text(time)}, but only time {_text(last)} is in the buffer"
    if time > last:
        return f"{begin} into the future.  Requested time {_text(time)} but the latest data is at time {_text(last)}"
    return f"{begin} into the past.  Requested time {_text(time)} but the earliest data is at time {_text(first)}"


def _nanoseconds(time: Time) -> int:
    return time.sec * 1_000_000_000 + time.nanosec


def _text(nanoseconds: int) -> str:
    return f"{nanoseconds / 1e9:.6f}"


def _stamped(target: str, source: str, stamp: int, rigid: Rigid) -> TransformStamped:
    sec, nanosec = divmod(stamp, 1_000_000_000)
    x, y, z = rigid.translation
    qx, qy, qz, qw = rigid.rotation
    return TransformStamped(
        header=Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id=target),
        child_frame_id=source,
        transform=Transform(translation=Vector3(x=x, y=y, z=z), rotation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
    )
