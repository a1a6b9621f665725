"""The runtime: starts and supervises all components."""

from homebot.runtime.plan import Plan, make_plan
from homebot.runtime.runtime import Runtime
from homebot.runtime.supervisor import Supervisor

__all__ = ["Plan", "Runtime", "Supervisor", "make_plan"]
