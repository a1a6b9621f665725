"""The runtime: starts and supervises all components."""

from homebot.runtime.plan import Plan, index_place, make_plan
from homebot.runtime.runtime import Runtime
from homebot.runtime.supervisor import Supervisor

__all__ = ["Plan", "Runtime", "Supervisor", "index_place", "make_plan"]
