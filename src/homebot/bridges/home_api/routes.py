"""The routes of the HTTP API."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, Final, NamedTuple

from pydantic import BaseModel

from homebot.bridges.home_api import answers, shapes
from homebot.bridges.home_api.device_search import HomeCalls

__all__ = ["ROUTES", "ApiRoute"]


class ApiRoute(NamedTuple):
    """One route.

    Attributes:
        method: Its method.
        path: Its path; at the end ``{id}`` for one that may have slashes.
        question: The shape of its parameters, or of its body.
        answer: The shape of its answer.
        handle: Answers it.
    """

    method: str
    path: str
    question: type[BaseModel]
    answer: type[BaseModel]
    handle: Callable[[HomeCalls, Any], Awaitable[BaseModel]]


ROUTES: Final = (
    ApiRoute("GET", "/api/home", shapes.NoQuestion, shapes.HomeAnswer, answers.home_in_short),
    ApiRoute("GET", "/api/devices", shapes.ListQuestion, shapes.DeviceList, answers.find_devices),
    ApiRoute("GET", "/api/devices/{id}", shapes.DeviceQuestion, shapes.DeviceDetails, answers.device_details),
    ApiRoute("POST", "/api/command", shapes.CommandQuestion, shapes.OutcomeAnswer, answers.command),
    ApiRoute("GET", "/api/why/{id}", shapes.WhyQuestion, shapes.WhyAnswer, answers.why),
    ApiRoute("GET", "/api/history", shapes.HistoryQuestion, shapes.HistoryAnswer, answers.history),
)
