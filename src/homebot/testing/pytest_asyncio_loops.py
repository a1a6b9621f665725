"""Fixtures that return the loop of a test that pytest-asyncio runs; loaded only where that is.

A loop lives as long as its scope: for one test, or for those of a class, module, package or session.
"""

import asyncio
from collections.abc import Callable
from typing import Literal

import pytest_asyncio


def _loop_of(scope: Literal["function", "class", "module", "package", "session"]) -> Callable[[], object]:
    @pytest_asyncio.fixture(loop_scope=scope, name=f"_homebot_{scope}_loop")
    async def running_loop() -> asyncio.AbstractEventLoop:
        return asyncio.get_running_loop()

    return running_loop


function_loop, class_loop, module_loop = _loop_of("function"), _loop_of("class"), _loop_of("module")
package_loop, session_loop = _loop_of("package"), _loop_of("session")
