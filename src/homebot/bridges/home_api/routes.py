"""The routes of the HTTP API, and their description in OpenAPI 3.1."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from functools import cache
from typing import Any, Final, NamedTuple

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from homebot.bridges.home_api import answers, shapes
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.version import __version__

__all__ = ["ROUTES", "ApiRoute", "openapi_text"]

_REFERENCE: Final = "#/components/schemas/{model}"


class ApiRoute(NamedTuple):
    """One route; ``{id}`` stands at the end of its path and may have slashes."""

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


@cache
def openapi_text() -> bytes:
    """Return the description as JSON."""
    models: list[type[BaseModel]] = [shapes.Problem, *(one.answer for one in ROUTES)]
    models += [one.question for one in ROUTES if one.method == "POST"]
    _, schemas = models_json_schema([(one, "serialization") for one in models], ref_template=_REFERENCE)
    paths: dict[str, Any] = {}
    for route in ROUTES:
        paths.setdefault(route.path, {})[route.method.lower()] = _operation(route)
    document = {
        "openapi": "3.1.0",
        "info": {"title": "homebot", "version": __version__},
        "security": [{}, {"token": []}],
        "paths": paths,
        "components": {
            "schemas": schemas["$defs"],
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
    }
    return json.dumps(document, separators=(",", ":")).encode()


def _operation(route: ApiRoute) -> dict[str, Any]:
    answer = {"description": "Done.", "content": {"application/json": {"schema": _named(route.answer)}}}
    problem = {"content": {"application/problem+json": {"schema": _named(shapes.Problem)}}}
    too_long = {"description": "The address is longer than 8 KiB.", "content": {"text/plain": {}}}
    problems = {str(one.value): {"description": one.phrase, **problem} for one in shapes.PROBLEMS}
    operation: dict[str, Any] = {
        "operationId": route.handle.__name__,
        "summary": (route.handle.__doc__ or "").partition("\n")[0],
        "responses": {"200": answer, "414": too_long, **problems},
    }
    if route.method == "POST":
        content = {"application/json": {"schema": _named(route.question)}}
        return {**operation, "requestBody": {"required": True, "content": content}}
    schema = route.question.model_json_schema(ref_template=_REFERENCE)
    return {
        **operation,
        "parameters": [
            {
                "name": name,
                "in": "path" if f"{{{name}}}" in route.path else "query",
                "required": name in schema.get("required", ()),
                "schema": field,
            }
            for name, field in schema.get("properties", {}).items()
        ],
    }


def _named(model: type[BaseModel]) -> dict[str, str]:
    return {"$ref": _REFERENCE.format(model=model.__name__)}
