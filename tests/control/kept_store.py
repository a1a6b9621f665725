"""A store for tests of what is known after a restart."""

from homebot.journal.store import JournalStore, LearntRow


class KeptStore(JournalStore):
    """A store of which what was learnt outlives a restart, without a file and its thread."""

    def __init__(self) -> None:
        super().__init__(1000, 86_400.0)
        self.rows: dict[tuple[str, str], LearntRow] = {}
        self.remembers = True

    def learn(self, row: LearntRow) -> None:
        self.rows[row.kind, row.name] = row
        if not row.record:
            del self.rows[row.kind, row.name]

    async def learnt(self) -> tuple[LearntRow, ...]:
        return tuple(self.rows.values())
