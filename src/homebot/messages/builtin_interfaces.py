"""ROS ``builtin_interfaces``: points in time and durations."""

from __future__ import annotations

from functools import lru_cache

from homebot.messages.message import Int32, Message, UInt32

_NANOSECONDS = 1_000_000_000
_FIRST, _LAST = -(2.0**31), 2.0**31 - 1


class Time(Message, ros_type="builtin_interfaces/msg/Time"):
    """A point in time.

    Attributes:
        sec: Whole seconds since the Unix epoch, UTC.
        nanosec: Nanoseconds after that, 0 to 999,999,999.
    """

    sec: Int32
    nanosec: UInt32

    @staticmethod
    @lru_cache(maxsize=256)
    def from_seconds(seconds: float) -> Time:
        """Return the point *seconds* after the Unix epoch, to the nearest nanosecond.

        :meth:`to_seconds` of a point later than 1970 is the same float again.

        A time before 1901 or after January 2038, from a wrongly set clock, becomes the nearest possible one: a wrong
        stamp is better than none. The last ones are cached, because messages of one moment share their stamp.
        """
        sec, nanosec = _split(min(max(seconds, _FIRST), _LAST))
        return _time_of(sec=sec, nanosec=nanosec)

    def to_seconds(self) -> float:
        """Return seconds since the Unix epoch."""
        return self.sec + self.nanosec / _NANOSECONDS


_time_of = Time.of_checked  # looked up once, see `of_checked`


class Duration(Message, ros_type="builtin_interfaces/msg/Duration"):
    """A span of time; its sign is that of ``sec``.

    Attributes:
        sec: Whole seconds, rounded down.
        nanosec: Nanoseconds to add, 0 to 999,999,999.
    """

    sec: Int32
    nanosec: UInt32

    @classmethod
    def from_seconds(cls, seconds: float) -> Duration:
        """Return the span of *seconds*."""
        sec, nanosec = _split(seconds)
        return cls(sec=sec, nanosec=nanosec)

    def to_seconds(self) -> float:
        """Return the span in seconds."""
        return self.sec + self.nanosec / _NANOSECONDS


def _split(seconds: float) -> tuple[int, int]:
    """Return the whole seconds below *seconds*, and the nanoseconds after them.

    They are split before the nanoseconds are computed, because a float cannot represent all since 1970.
    """
    whole, part = divmod(seconds, 1.0)
    sec, nanosec = int(whole), round(part * _NANOSECONDS)
    return (sec, nanosec) if nanosec < _NANOSECONDS else (sec + 1, 0)
