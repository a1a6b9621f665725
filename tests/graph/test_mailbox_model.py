"""The mailbox and its keyed queue against a list."""

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from tests.sizes import examples

from homebot.graph.mailbox import KeyedQueue, Mailbox, keyed_queue

Item = tuple[str, int]

keys = st.sampled_from("abc")


class PlainMailbox(RuleBasedStateMachine):
    """A mailbox is a list that loses its front."""

    @initialize(depth=st.integers(1, 4))
    def make(self, depth: int) -> None:
        self.depth = depth
        self.mailbox: Mailbox[int] = Mailbox(depth)
        self.model: list[int] = []
        self.lost = 0
        self.closed = False
        self.count = 0

    @rule()
    def put(self) -> None:
        self.count += 1
        self.mailbox.put(self.count)
        if self.closed:
            return
        if len(self.model) == self.depth:
            self.model.pop(0)
            self.lost += 1
        self.model.append(self.count)

    @rule()
    def take(self) -> None:
        assert self.mailbox.take() == (self.model.pop(0) if self.model else None)

    @rule()
    def close(self) -> None:
        self.mailbox.close()
        self.closed = True

    @invariant()
    def agree(self) -> None:
        if hasattr(self, "mailbox"):
            assert len(self.mailbox.queue) == len(self.model)
            assert self.mailbox.lost == self.lost
            assert self.mailbox.has_room_for(0) == (self.closed or len(self.model) < self.depth)


class KeyedMailbox(RuleBasedStateMachine):
    """A keyed queue is a list of which at most ``depth`` items have one key."""

    @initialize(depth=st.integers(1, 3))
    def make(self, depth: int) -> None:
        self.depth = depth
        self.losses = 0
        self.queue: KeyedQueue[Item] = keyed_queue(depth, lambda item: item[0], self._lose)
        self.model: list[Item] = []
        self.dropped = 0
        self.count = 0

    def _lose(self, _item: Item) -> None:
        self.losses += 1

    @rule(key=keys)
    def append(self, key: str) -> None:
        self.count += 1
        item = (key, self.count)
        same = [one for one in self.model if one[0] == key]
        assert self.queue.has_room_for(item) == (len(same) < self.depth)
        if len(same) == self.depth:
            self.model.remove(same[0])
            self.dropped += 1
        self.model.append(item)
        self.queue.append(item)

    @rule()
    def popleft(self) -> None:
        if self.model:
            assert self.queue.popleft() == self.model.pop(0)

    @rule(key=keys)
    def discard(self, key: str) -> None:
        self.queue.discard(key)
        self.model = [one for one in self.model if one[0] != key]

    @invariant()
    def agree(self) -> None:
        if hasattr(self, "queue"):
            assert list(self.queue) == self.model
            assert len(self.queue) == len(self.model)
            assert self.losses == self.dropped


brief = settings(max_examples=examples(60), stateful_step_count=30, deadline=None)
TestPlainMailbox = PlainMailbox.TestCase
TestPlainMailbox.settings = brief
TestKeyedMailbox = KeyedMailbox.TestCase
TestKeyedMailbox.settings = brief
