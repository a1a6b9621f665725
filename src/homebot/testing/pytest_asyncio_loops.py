"""Fixtures that tell the loop of a test that pytest-asyncio runs; loaded only where that is.

A loop lives as long as its scope: for one test, or for those of a class, module, package or session.
"""

from __future__ import annotations

import asyncio

import pytest_asyncio

__all__ = ["class_loop", "function_loop", "module_loop", "package_loop", "session_loop"]


@pytest_asyncio.fixture(loop_scope="function", name="_homebot_function_loop")
async def function_loop() -> asyncio.AbstractEventLoop:
    """The loop of this test alone."""
    return asyncio.get_running_loop()


@pytest_asyncio.fixture(loop_scope="class", name="_homebot_class_loop")
async def class_loop() -> asyncio.AbstractEventLoop:
    """The loop of this test's class."""
    return asyncio.get_running_loop()


@pytest_asyncio.fixture(loop_scope="module", name="_homebot_module_loop")
async def module_loop() -> asyncio.AbstractEventLoop:
    """The loop of this test's module."""
    return asyncio.get_running_loop()


@pytest_asyncio.fixture(loop_scope="package", name="_homebot_package_loop")
async def package_loop() -> asyncio.AbstractEventLoop:
    """The loop of this test's package."""
    return asyncio.get_running_loop()


@pytest_asyncio.fixture(loop_scope="session", name="_homebot_session_loop")
async def session_loop() -> asyncio.AbstractEventLoop:
    """The loop of all tests."""
    return asyncio.get_running_loop()
