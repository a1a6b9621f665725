"""Import of the automations of another program: the contract of its readers, by entry point. Pure."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, Protocol, TypeAlias

from homebot.devices.device import Device
from homebot.support.located import Located

IMPORTERS: Final = "homebot.automation_readers"
"""The entry-point group."""


class Refusal(NamedTuple):
    """A part of an automation that is not carried over.

    Attributes:
        name: The automation.
        problem: The part, with the reason.
    """

    line: int
    name: str
    problem: str


class ImportedRoutines(NamedTuple):
    """The routines of a file.

    Attributes:
        texts: Tables ``[[routines]]``, each with comments that name its source and its devices.
        refused: All that was not carried over; an automation with one of these has no text.
        total: The number of automations.
    """

    texts: tuple[str, ...]
    refused: tuple[Refusal, ...]
    total: int


class NamedRoutine(Protocol):
    """A routine that has no mistake."""

    @property
    def app(self) -> str:
        """The name of its app, which no other may have."""

    @property
    def name(self) -> str:
        """Its name for people."""


RoutineCheck: TypeAlias = Callable[[str, str], NamedRoutine]
"""Checks the text of a routine from a source; raises ConfigError if it is wrong."""


Load: TypeAlias = Callable[[str], Located]
"""Returns another file, by its path from the one that names it; raises UsageError if it cannot be read."""


class AutomationReader(Protocol):
    """A reader of the automations of one program."""

    def read(
        self,
        document: Located,
        source: str,
        devices: Sequence[Device],
        check: RoutineCheck,
        *,
        scenes: Sequence[str] = (),
        routines: Sequence[str] = (),
        load: Load | None = None,
        blueprint: Located | None = None,
    ) -> ImportedRoutines:
        """Return the routines for the automations in *document*, which are carried over in full or refused.

        Args:
            source: The name of the file.
            devices: The devices of the house, for the names in the automations.
            check: Checks each routine.
            scenes: The names of the scenes of the house.
            routines: The names of its routines.
            load: Reads the files that *document* names; without it they are refused.
            blueprint: The blueprint of all automations that name one.

        Raises:
            UsageError: It contains no automations.
        """
        ...
