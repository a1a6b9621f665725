"""The route of the HTTP API for the history."""

from datetime import UTC, datetime
from http import HTTPStatus
from typing import Annotated, Final, cast

from pydantic import Field

from homebot.bridges.home_api.answers import call_or_fail, short_value
from homebot.bridges.home_api.device_search import HomeCalls, meant_device
from homebot.bridges.home_api.routes import ApiRoute
from homebot.bridges.home_api.shapes import Answer, ProblemError, Question, ShortName, ShortValue
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.history_messages import HistorySeries, ReadHistoryResponse
from homebot.devices.value import ShortText
from homebot.devices.wording.time_format import from_seconds
from homebot.features.history import READ_HISTORY
from homebot.support.names import did_you_mean
from homebot.support.printable import printable
from homebot.units import parse_duration

MAX_POINTS: Final = 500
"""Values of each capability in a history."""

_WIDEST: Final = 100
_FLAGS: Final = {"true": True, "false": False}


class HistoryQuestion(Question):
    """A device, a capability (empty for all), and the length of time, such as `24h` or `7d`."""

    device: ShortName
    capability: ShortText = ""
    since: Annotated[str, Field(max_length=40)] = "24h"
    points: Annotated[int, Field(ge=1, le=MAX_POINTS)] = 50


class ValueSeries(Answer):
    """The values of a capability with their times; of numbers the mean of `width` seconds each if that is not 0."""

    capability: str
    part: str = ""
    unit: str = ""
    width: float = 0.0
    points: tuple[tuple[str, ShortValue], ...]


class HistoryAnswer(Answer):
    """The history of a device, and how many more series there are."""

    id: str
    series: tuple[ValueSeries, ...]
    more: int = 0


async def history(home: HomeCalls, asked: HistoryQuestion) -> HistoryAnswer:
    """Return the values of a device over a time."""
    since = from_seconds(max(0.0, home.now() - parse_duration(asked.since, "since")))
    if not home.offers(READ_HISTORY.name):
        problem = "no history is kept, or it has not begun yet; [history] of homebot.toml has `enabled = true` for one"
        raise ProblemError(HTTPStatus.SERVICE_UNAVAILABLE, problem)
    device, _ = await meant_device(home, asked.device)
    request = {"device": device.id, "capability": asked.capability, "since": since, "points": asked.points}
    response = cast("ReadHistoryResponse", await call_or_fail(home, READ_HISTORY.name, request))
    if not response.series and (name := asked.capability) and name not in CAPABILITIES:
        hint = did_you_mean(name, CAPABILITIES, "the answer without one names those of the device")
        raise ProblemError(HTTPStatus.BAD_REQUEST, f"capability: nothing has a value {name!r}; {hint}")
    return HistoryAnswer(id=device.id, series=tuple(map(_series, response.series)), more=response.left_out)


def _series(one: HistorySeries) -> ValueSeries:
    values = [_FLAGS.get(word, printable(word, _WIDEST)) for word in one.words] or map(short_value, one.values)
    times = (datetime.fromtimestamp(at, UTC).strftime("%Y-%m-%dT%H:%M:%SZ") for at in one.times)
    points = tuple((at, value) for at, value in zip(times, values, strict=True) if value is not None)
    return ValueSeries(capability=one.capability, part=one.part, unit=one.unit, width=one.width, points=points)


ROUTES: Final = (ApiRoute("GET", "/api/history", HistoryQuestion, HistoryAnswer, history),)
