"""The files that a run keeps beside each other, and their schemas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.apps.store_file import STORE_SCHEMA
from homebot.control.journal.journal_file import JOURNAL_SCHEMA
from homebot.discovery.store import INDEX_FILE, INDEX_SCHEMA
from homebot.history.history_file import HISTORY_SCHEMA
from homebot.runtime.app_host import STORE_FILE
from homebot.runtime.history_starter import HISTORY_FILE
from homebot.runtime.runtime import JOURNAL_FILE
from homebot.support.sqlite_file import SqliteSchema

__all__ = ["KEPT_FILES"]

KEPT_FILES: Final[Mapping[str, SqliteSchema]] = {
    INDEX_FILE: INDEX_SCHEMA,
    JOURNAL_FILE: JOURNAL_SCHEMA,
    HISTORY_FILE: HISTORY_SCHEMA,
    STORE_FILE: STORE_SCHEMA,
}
