"""What comes out of task groups."""

import anyio
import pytest

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.support.isolation import ungrouped

LOST = LinkError("the link broke")


async def fail(error: Exception) -> None:
    raise error


async def fail_together(*errors: Exception) -> None:
    with ungrouped():
        async with anyio.create_task_group() as tasks:
            for error in errors:
                tasks.start_soon(fail, error)


async def test_the_first_expected_error_comes_out_instead_of_its_group() -> None:
    with pytest.raises(LinkError, match="the link broke"):
        await fail_together(LOST, RefusedError("a login", "the password is wrong"))


async def test_a_group_with_another_error_stays_a_group() -> None:
    with pytest.raises(BaseExceptionGroup) as caught:
        await fail_together(LOST, UsageError("a mistake of ours"))
    assert len(caught.value.exceptions) == 2


def test_an_error_without_a_group_passes() -> None:
    with pytest.raises(LinkError, match="the link broke"), ungrouped():
        raise LOST
