"""Handles for devices that are turned on and off: lights, plugs, switches, sirens, fans and players."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, Unpack

from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import CommonFilters, HandleQuery
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

_OFF = "off"


class Light(Handle):
    """A lamp, which may also have a brightness, a colour temperature and a colour."""

    service_types: ClassVar[frozenset[str]] = frozenset({"light"})

    @classmethod
    def where(
        cls,
        *,
        on: bool | None = None,
        dimmable: bool | None = None,
        tunable: bool | None = None,
        colored: bool | None = None,
        **filters: Unpack[CommonFilters],
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            on: Whether it reports that it is on; an unknown state matches neither.
            dimmable: Whether its brightness can be set.
            tunable: Whether its colour temperature can be set.
            colored: Whether its colour can be set.
        """
        settable = {"level": dimmable, "color_temperature": tunable, "color": colored}
        return cls._where(filters, states={"on_off": on}, settable=settable)

    @property
    def on(self) -> bool | None:
        """True if it is on; None if unknown. A lamp that reports only its brightness is off at 0."""
        if (on := self._flag("on_off")) is not None or self.level is None:
            return on
        return self.level > 0

    @property
    def level(self) -> float | None:
        """The brightness in percent, 0 to 100; 0 only if it is off. None if unknown."""
        return self._number("level")

    @property
    def kelvin(self) -> float | None:
        """The colour temperature in kelvin; None if unknown."""
        return self._number("color_temperature")

    @property
    def color(self) -> tuple[float, float] | None:
        """The hue in degrees, 0 to 360, and the saturation in percent, 0 to 100; None if unknown."""
        match self.value("color"):
            case (float(hue), float(saturation)):
                return hue, saturation
            case _:
                return None

    @property
    def effect(self) -> str | None:
        """The name of the effect that is running; None if unknown or none."""
        return self._text("effect")

    async def turn_on(
        self,
        *,
        level: float | None = None,
        kelvin: float | None = None,
        color: tuple[float, ...] | list[float] | None = None,
        effect: str | None = None,
        transition: float = 0.0,
    ) -> Outcome:
        """Turn it on, by its brightness if it has no switch. Omitted settings stay as they are.

        Args:
            level: The brightness in percent, above 0 and up to 100.
            kelvin: The colour temperature in kelvin, within the bounds of the lamp's ``color_temperature``.
            color: The hue in degrees, 0 to 360, and the saturation in percent, 0 to 100.
            effect: One of the options of its ``effect``.
            transition: Seconds that the change takes, if the lamp supports that; 0 or more.

        Raises:
            RefusedError: It does not support one of these, or a value is out of range; nothing was sent.
        """
        if isinstance(level, int | float):
            with self._house.commander.refusals_logged(self.device, self.part_id):
                if not 0 < level <= 100:
                    raise RefusedError(f"{level:g} as level of {self.id}", "it takes a level above 0 and up to 100 %")
        if level is None and not self.can("on_off") and self.can("level"):
            level = self.level or 100.0  # it has no other switch
        settings: dict[str, PlainValue] = {"level": level, "color_temperature": kelvin}
        settings["color"] = tuple(color) if isinstance(color, list) else color
        settings["effect"] = effect
        settings = {name: value for name, value in settings.items() if value is not None} or {"on_off": True}
        return await self._set(settings, transition=transition)

    async def turn_off(self, *, transition: float = 0.0) -> Outcome:
        """Turn it off, by its brightness if it has no switch."""
        if not self.can("on_off") and self.can("level"):
            return await self.command("level", 0.0, transition=transition)
        return await self.command("on_off", False, transition=transition)  # noqa: FBT003  # the value

    async def set_level(self, level: float, *, transition: float = 0.0) -> Outcome:
        """Set the brightness to *level* percent; 0 turns it off.

        Raises:
            RefusedError: It cannot be dimmed, or the level is not in 0 to 100.
        """
        if level == 0:
            return await self.turn_off(transition=transition)
        return await self._set({"level": level}, transition=transition)


class _Switchable(Handle):
    @classmethod
    def where(cls, *, on: bool | None = None, **filters: Unpack[CommonFilters]) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            on: Whether it reports that it is on; an unknown state matches neither.
        """
        return cls._where(filters, states={"on_off": on})

    @property
    def on(self) -> bool | None:
        """True if it is on; None if unknown."""
        return self._flag("on_off")

    async def turn_on(self) -> Outcome:
        """Turn it on."""
        return await self.command("on_off", True)  # noqa: FBT003  # the value

    async def turn_off(self) -> Outcome:
        """Turn it off."""
        return await self.command("on_off", False)  # noqa: FBT003  # the value


class Plug(_Switchable):
    """A smart plug or socket."""

    service_types: ClassVar[frozenset[str]] = frozenset({"plug"})

    @property
    def power(self) -> float | None:
        """The power drawn in watts; None if unknown or not measured."""
        return self._number("power")


class Switch(_Switchable):
    """A relay or switch: an output with an unknown load."""

    service_types: ClassVar[frozenset[str]] = frozenset({"switch"})


class Siren(_Switchable):
    """A siren."""

    service_types: ClassVar[frozenset[str]] = frozenset({"siren"})


class Fan(_Switchable):
    """A fan, an air purifier or an extractor hood."""

    service_types: ClassVar[frozenset[str]] = frozenset({"fan"})

    @property
    def on(self) -> bool | None:
        """True if it is on; None if unknown. A fan that reports only its speed is off at 0."""
        if (on := self._flag("on_off")) is not None:
            return on
        if self.speed is not None:
            return self.speed > 0
        return None if self.mode is None else self.mode.casefold() != _OFF

    @property
    def speed(self) -> float | None:
        """The speed in percent, 0 to 100; None if unknown."""
        return self._number("fan_speed")

    @property
    def mode(self) -> str | None:
        """The selected preset, one of the options of its ``fan_mode``; None if unknown."""
        return self._text("fan_mode")

    async def turn_on(self, *, speed: float | None = None) -> Outcome:
        """Turn it on.

        Args:
            speed: The speed in percent, 0 to 100; by default it stays as it is.

        Raises:
            RefusedError: It does not support this; nothing was sent.
        """
        settings: dict[str, PlainValue] = {}
        if speed is None or self.can("on_off"):
            settings["on_off"] = True
        if speed is not None:
            settings["fan_speed"] = speed
        return await self._set(settings)

    async def turn_off(self) -> Outcome:
        """Turn it off, by its speed or preset if it has no switch."""
        if not self.can("on_off") and (mode := self._mode_off()) is not None:
            return await self.command("fan_mode", mode)
        if not self.can("on_off") and self.can("fan_speed"):
            return await self.command("fan_speed", 0.0)
        return await self.command("on_off", False)  # noqa: FBT003  # the value

    async def set_speed(self, speed: float) -> Outcome:
        """Set the speed to *speed* percent, 0 to 100.

        Raises:
            RefusedError: Its speed cannot be set, or the value is out of range.
        """
        return await self._set({"fan_speed": speed})

    def _mode_off(self) -> str | None:
        """Return the preset that means off; None if there is none."""
        options = [
            word
            for capability in self.capabilities
            if capability.name == "fan_mode" and capability.settable
            for word in capability.options
        ]
        return next((word for word in options if word.casefold() == _OFF), None)


class MediaPlayer(_Switchable):
    """A television, a projector, a speaker or another player."""

    service_types: ClassVar[frozenset[str]] = frozenset({"video_player", "speaker"})

    @classmethod
    def where(
        cls, *, on: bool | None = None, state: str | None = None, **filters: Unpack[CommonFilters]
    ) -> HandleQuery[Self]:
        """Return the query that ``find`` and ``follow`` build from these arguments.

        Args:
            on: Whether it reports that it is on; an unknown state matches neither.
            state: The activity that it reports; see :attr:`state`.
        """
        return cls._where(filters, states={"on_off": on, "playback": state})

    @property
    def state(self) -> str | None:
        """``playing``, ``paused``, ``stopped`` or ``buffering``; None if unknown."""
        return self._text("playback")

    @property
    def volume(self) -> float | None:
        """The volume in percent, 0 to 100; None if unknown."""
        return self._number("volume")

    @property
    def muted(self) -> bool | None:
        """True if its sound is muted; None if unknown."""
        return self._flag("muted")

    async def play(self) -> Outcome:
        """Play, or resume after a pause."""
        return await self.command("playback", "playing")

    async def pause(self) -> Outcome:
        """Pause where it is."""
        return await self.command("playback", "paused")

    async def stop(self) -> Outcome:
        """Stop playing."""
        return await self.command("playback", "stopped")

    async def mute(self, muted: bool = True) -> Outcome:  # noqa: FBT001, FBT002 - the value
        """Mute or unmute its sound."""
        return await self.command("muted", muted)

    async def set_volume(self, volume: float) -> Outcome:
        """Set the volume to *volume* percent.

        Raises:
            RefusedError: Its volume cannot be set, or is not in 0 to 100.
        """
        return await self._set({"volume": volume})
