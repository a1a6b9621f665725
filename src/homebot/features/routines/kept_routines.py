"""The routines that people wrote by a command; they are kept with the values of the apps."""

import shlex
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import contextmanager
from typing import Any, Final, final

from homebot.apps.grants import scope_of
from homebot.config import Config
from homebot.devices.client_rights import EDIT_ROUTINE
from homebot.errors import ConfigError, UsageError
from homebot.features.routines.text import WrittenRoutine, read_routines

_MAX_ROUTINES: Final = 300
_MAX_PROPOSED: Final = 20


@final
class KeptRoutines:
    """The kept routines.

    Args:
        store: By the name of its app, the text of each, the client that proposed it (empty for an approved one), and
            whether it is of a habit.
        on_change: Called with the name of the app of each routine that was put, or removed.
        problems: Why a routine does not run, by the name of its app.
    """

    def __init__(
        self, store: MutableMapping[str, Any], on_change: Callable[[str], None], problems: dict[str, str]
    ) -> None:
        self._store = store
        self._on_change = on_change
        self.problems = problems

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._store))

    def __contains__(self, app: object) -> bool:
        return app in self._store

    def text(self, app: str) -> str:
        """Return the text of a routine."""
        return str(self._store[app]["text"])

    def proposed_by(self, app: str) -> str:
        """Return the client that proposed a routine; empty if it is not kept, or a person approved it."""
        return str(self._store[app]["by"]) if app in self._store else ""

    def is_of_habit(self, app: str) -> bool:
        """Return whether a routine is kept that was made of a habit."""
        return app in self._store and bool(self._store[app].get("habit"))

    def put(self, routine: WrittenRoutine, proposed_by: str = "", *, of_habit: bool = False) -> None:
        """Keep *routine* in place of one of its name.

        Raises:
            UsageError: There are too many, or too many proposals.
        """
        is_new = routine.app not in self
        if is_new and len(self._store) >= _MAX_ROUTINES:
            raise UsageError(
                f"{_MAX_ROUTINES} routines are kept, which is the limit; remove one, or write it into homebot.toml"
            )
        if is_new and proposed_by and sum(bool(self.proposed_by(one)) for one in self) >= _MAX_PROPOSED:
            raise UsageError(f"{_MAX_PROPOSED} proposals wait for the owner, which is the limit")
        self._store[routine.app] = {"text": routine.text, "by": proposed_by} | (
            {"habit": True} if of_habit or self.is_of_habit(routine.app) else {}
        )
        self.problems.pop(routine.app, None)
        self._on_change(routine.app)

    @contextmanager
    def restored_on_error(self, app: str) -> Iterator[None]:
        """Bring back the kept text of *app* if the block fails."""
        before = self._store.get(app)
        try:
            yield
        except BaseException:
            self.remove(app)
            if before is not None:
                self._store[app] = dict(before)
                self._on_change(app)
            raise

    def approve(self, app: str) -> None:
        """Make a proposal the owner's."""
        if self.proposed_by(app):
            self._store[app] = {"text": self.text(app), "by": ""}

    def remove(self, app: str) -> None:
        """Remove a routine."""
        self._store.pop(app, None)
        self.problems.pop(app, None)
        self._on_change(app)

    def grants(self, app: str) -> tuple[str, tuple[str, ...] | None]:
        """Return the command that gives a routine further rights, and its scope; None for that of every app.

        Raises:
            ConfigError: Its text is wrong.
        """
        routine = self._read(app)
        return f"{EDIT_ROUTINE}{shlex.quote(routine.name)}", scope_of(f"routines.{app}", routine.table, app)

    def added_to(self, config: Config, app: str) -> Config:
        """Return *config* with the routine of *app*, if it is kept and right, and *config* has no app of that name."""
        if app not in self:
            return config
        if app in config.apps:
            self.problems[app] = f"{config.source} has a routine or app {app} too; rename or remove one of them"
            return config
        try:
            return config.model_copy(update={"apps": {app: self._read(app).table, **config.apps}})
        except ConfigError as exc:
            self.problems[app] = str(exc)
            return config

    def _read(self, app: str) -> WrittenRoutine:
        (routine,) = read_routines(self.text(app), f"the routine {app}")
        if self.proposed_by(app):
            return routine._replace(table=routine.table | {"enabled": False})
        return routine
