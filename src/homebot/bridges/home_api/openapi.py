"""The description of the HTTP API in OpenAPI 3.1, made of its routes and shapes."""

from __future__ import annotations

import json
from functools import cache
from typing import Any, Final

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from homebot.bridges.home_api.problem import PROBLEMS
from homebot.bridges.home_api.routes import ROUTES, ApiRoute
from homebot.bridges.home_api.shapes import Problem
from homebot.version import __version__

__all__ = ["openapi_text"]

_REFERENCE: Final = "#/components/schemas/{model}"


@cache
def openapi_text() -> bytes:
    """Return the description as JSON."""
    models: list[type[BaseModel]] = [Problem, *(one.answer for one in ROUTES)]
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
    problem = {"content": {"application/problem+json": {"schema": _named(Problem)}}}
    problems = {str(one.value): {"description": one.phrase, **problem} for one in PROBLEMS}
    operation: dict[str, Any] = {
        "operationId": route.handle.__name__,
        "summary": (route.handle.__doc__ or "").partition("\n")[0],
        "responses": {"200": answer, **problems},
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
