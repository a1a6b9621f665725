"""Coordinate frames over time, with the names, rules and error texts of tf2, for apps and robots. Pure.

Source: geometry2 0.39.1, ``tf2/src/buffer_core.cpp`` and ``time_cache.cpp``.
"""

import math
from bisect import bisect_left, bisect_right, insort
from collections.abc import Sequence
from operator import attrgetter
from typing import NamedTuple, final

from homebot.errors import HomebotError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from homebot.messages.std_msgs import Header
from homebot.places.rigid import IDENTITY, Rigid

CACHE_TIME = 10_000_000_000
"""Nanoseconds for which transforms are kept, counted back from the newest one of the frame."""

MAX_DEPTH = 100
"""The limit of frames between a frame and the root of its tree: each ancestor costs time at each transform."""

MAX_FRAMES = 1000
MAX_SAMPLES = 10_000
"""The limit of transforms of one frame; the oldest is dropped for a newer one."""

NORM_TOLERANCE = 0.01
_SECOND = 1_000_000_000


class TransformException(HomebotError):
    """A transform is not available, or is refused."""


class LookupException(TransformException):
    """A frame does not exist."""


class ConnectivityException(TransformException):
    """Two frames are not part of one tree."""


class ExtrapolationException(TransformException):
    """The transform at the requested time would have to be extrapolated."""


class InvalidArgumentException(TransformException):
    """The name of a frame or a transform is invalid."""


class Sample(NamedTuple):
    """A transform of a frame at a time, in nanoseconds."""

    stamp: int
    parent: str
    rigid: Rigid


_stamp = attrgetter("stamp")


@final
class TransformBuffer:
    """The frames of one robot or house, and the transforms between them.

    Its methods have tf2's names, for apps written for that.
    """

    def __init__(self) -> None:
        self._moving: dict[str, list[Sample]] = {}  # by time
        self._static: dict[str, Sample] = {}
        self._frames: set[str] = set()

    def set_transform(self, transform: TransformStamped, authority: str = "") -> bool:
        """Insert *transform*; return False if it is too old.

        Args:
            authority: The sender, for errors.

        Raises:
            InvalidArgumentException: A frame name is empty, a frame is its own ancestor, a number is not finite, the
                quaternion is not of length 1, or there are too many frames.
        """
        return self.insert(transform.child_frame_id.removeprefix("/"), _sample_of(transform), authority)

    def set_transform_static(self, transform: TransformStamped, authority: str = "") -> None:
        """Insert *transform*, which holds at any time, as :meth:`set_transform` does."""
        self.insert(transform.child_frame_id.removeprefix("/"), _sample_of(transform), authority, is_static=True)

    def insert(self, child: str, sample: Sample, authority: str, *, is_static: bool = False) -> bool:
        """Insert a transform of the frame *child*, without a leading slash, as :meth:`set_transform` does."""
        if problem := self._problem(child, sample):
            sender, ends = f" from {authority}" if authority else "", (child[:100], sample.parent[:100])
            raise InvalidArgumentException(f"the transform{sender} from {ends[0]!r} to {ends[1]!r} {problem}")
        self._frames |= {sample.parent, child}
        if is_static:
            self._static[child] = sample
            self._moving.pop(child, None)
            return True
        samples = self._moving.get(child, [])
        if not samples or sample.stamp > samples[-1].stamp:
            samples.append(sample)
            oldest = bisect_right(samples, sample.stamp - CACHE_TIME - 1, key=_stamp)
            del samples[: max(oldest, len(samples) - MAX_SAMPLES)]
        elif sample.stamp < samples[-1].stamp - CACHE_TIME:
            return False
        elif sample not in samples[bisect_left(samples, sample.stamp, key=_stamp) :]:
            insort(samples, sample, key=_stamp)
        self._moving[child] = samples
        self._static.pop(child, None)
        return True

    def lookup_transform(self, target_frame: str, source_frame: str, time: Time | None = None) -> TransformStamped:
        """Return the transform that maps points of *source_frame* into *target_frame*.

        Args:
            time: The time; None or zero for the latest time at which all frames between them are known.

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
        for argument, frame in asked.items():
            if frame not in self._frames and target_frame != source_frame:
                raise LookupException(f'"{frame}" passed to lookupTransform argument {argument} does not exist. ')
        at = (0 if time is None else _nanoseconds(time)) or self._latest_common(target_frame, source_frame)
        (x, y, z), (qx, qy, qz, qw) = self._between(target_frame, source_frame, at)
        sec, nanosec = divmod(at, _SECOND)
        return TransformStamped(
            header=Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id=target_frame),
            child_frame_id=source_frame,
            transform=Transform(translation=Vector3(x=x, y=y, z=z), rotation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
        )

    def can_transform(self, target_frame: str, source_frame: str, time: Time | None = None) -> bool:
        """Return whether :meth:`lookup_transform` finds one."""
        try:
            self.lookup_transform(target_frame, source_frame, time)
        except TransformException:
            return False
        return True

    def clear(self) -> None:
        """Remove all transforms except static ones."""
        self._moving = {}

    def _problem(self, child: str, sample: Sample) -> str:
        parent, rigid = sample.parent, sample.rigid
        if not parent or not child:
            return "lacks the name of a frame"
        if parent == child:
            return "has the same frame at both ends"
        if not all(map(math.isfinite, (*rigid.translation, *rigid.rotation))):
            return "has a number that is not finite"
        if abs(sum(component * component for component in rigid.rotation) - 1) >= NORM_TOLERANCE:
            return f"has a quaternion that is not of length 1: {rigid.rotation}"
        if child in (above := self._above(parent)):
            return "would make the frame its own ancestor"
        if len(above) >= MAX_DEPTH:
            return f"is of a frame more than {MAX_DEPTH} below the root"
        if len(self._frames) + len({parent, child} - self._frames) > MAX_FRAMES:
            return f"is of one frame more than {MAX_FRAMES:,}"
        return ""

    def _above(self, frame: str) -> list[str]:
        """Return *frame* and its ancestors according to the newest transforms, up to the limit."""
        above = [frame]
        while len(above) < MAX_DEPTH and (frame in self._static or frame in self._moving):
            frame = (self._static.get(frame) or self._moving[frame][-1]).parent
            above.append(frame)
        return above

    def _latest_common(self, target: str, source: str) -> int:
        """Return the newest time at which all transforms between two frames are known; 0 if all are static."""
        above_target, above_source = set(self._walk(target)[0]), set(self._walk(source)[0])
        if above_target.isdisjoint(above_source):
            raise _unconnected(target, source)
        between = {source} if target == source else above_target ^ above_source
        stamps = [self._moving[frame][-1].stamp for frame in between if frame in self._moving]
        return min(filter(None, stamps), default=0)

    def _between(self, target: str, source: str, time: int) -> Rigid:
        up, first_problem = self._walk(source, time)
        down, problem = self._walk(target, time)
        for frame, way in down.items():
            if frame in up:
                return way.inverse().then(up[frame])
        if problem := problem or first_problem:
            where = f", when looking up transform from frame [{source}] to frame [{target}]"
            raise ExtrapolationException(f"{problem}{where}")
        raise _unconnected(target, source)

    def _walk(self, frame: str, time: int = 0) -> tuple[dict[str, Rigid], str]:
        """Return *frame* and its ancestors at *time*, by default the newest, each with the transform into it.

        The second value is the reason why there are no more; empty for the root.
        """
        walked = {frame: IDENTITY}
        while frame in self._static or frame in self._moving:
            try:
                sample = self._static.get(frame) or _at(self._moving[frame], time)
            except ExtrapolationException as exc:
                return walked, str(exc)
            if sample.parent in walked:  # at an older time frames may have formed a loop
                raise LookupException(f"The tf tree is invalid because it contains a loop at frame [{sample.parent}]")
            if len(walked) > MAX_DEPTH:  # after trees were joined
                raise LookupException(f"The tf tree is deeper than {MAX_DEPTH} frames at frame [{sample.parent}]")
            walked[sample.parent] = sample.rigid.then(walked[frame])
            frame = sample.parent
        return walked, ""


def _sample_of(transform: TransformStamped) -> Sample:
    parent = transform.header.frame_id.removeprefix("/")
    return Sample(_nanoseconds(transform.header.stamp), parent, rigid_of(transform.transform))


def rigid_of(transform: Transform) -> Rigid:
    """Return *transform* as a :class:`Rigid`."""
    moved, turned = transform.translation, transform.rotation
    return Rigid((moved.x, moved.y, moved.z), (turned.x, turned.y, turned.z, turned.w))


def _at(samples: Sequence[Sample], time: int) -> Sample:
    """Return the transform at *time*, interpolated between two with the same parent; the newest for 0."""
    first, last = samples[0].stamp, samples[-1].stamp
    if not time:
        return samples[-1]
    if not first <= time <= last:
        at, begin = f"time {time / _SECOND:.6f}", "Lookup would require extrapolation"
        if first == last:
            raise ExtrapolationException(f"{begin} at {at}, but only time {last / _SECOND:.6f} is in the buffer")
        way, known, end = ("future", "latest", last) if time > last else ("past", "earliest", first)
        data = f"the {known} data is at time {end / _SECOND:.6f}"
        raise ExtrapolationException(f"{begin} into the {way}.  Requested {at} but {data}")
    index = bisect_right(samples, time, key=_stamp)
    earlier = samples[index - 1]
    if earlier.stamp == time:
        return earlier
    later = samples[index]
    if earlier.parent != later.parent:
        return earlier
    share = (time - earlier.stamp) / (later.stamp - earlier.stamp)
    return Sample(time, earlier.parent, earlier.rigid.between(later.rigid, share))


def _unconnected(target: str, source: str) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target}' and '{source}' because they are not part of the same tree."
        f"Tf has two or more unconnected trees."
    )


def _nanoseconds(time: Time) -> int:
    return time.sec * _SECOND + time.nanosec
