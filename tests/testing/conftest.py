"""Test runs inside of tests."""

import gc
import shlex
import warnings
from collections.abc import Callable, Iterator, Sequence

import pytest

Tried = Callable[..., pytest.RunResult]
ANYIO_ON_ASYNCIO = "import pytest\n\n@pytest.fixture\ndef anyio_backend():\n    return 'asyncio'\n"


@pytest.fixture(autouse=True)
def _inner_runs_keep_their_order(request: pytest.FixtureRequest) -> Iterator[None]:
    """Also where a plug-in that shuffles is installed: the tests read what an inner run says, in its order."""
    if "pytester" in request.fixturenames:
        request.getfixturevalue("pytester")  # it removes these options when it is made
        with warnings.catch_warnings():  # of what earlier tests left: the inner run would fail with them
            warnings.simplefilter("ignore")
            gc.collect()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_ADDOPTS", "-p no:randomly")
        yield


@pytest.fixture
def tried(pytester: pytest.Pytester) -> Tried:
    """Run the tests of a source in this process; check how they ended, and that the *lines* came."""

    def run(
        source: str, options: str = "", *, conftest: str = "", lines: Sequence[str] = (), **outcomes: int
    ) -> pytest.RunResult:
        if conftest:
            pytester.makeconftest(conftest)
        if source:
            pytester.makepyfile(source)
        scope = () if "no:asyncio" in options else ("-o", "asyncio_default_fixture_loop_scope=function")
        result = pytester.runpytest_inprocess(
            "-p", "no:cacheprovider", "--strict-markers", *scope, *shlex.split(options)
        )
        result.assert_outcomes(**outcomes)
        result.stdout.fnmatch_lines(lines)
        return result

    return run
