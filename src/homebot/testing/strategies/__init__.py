"""Hypothesis strategies: random houses, random days in them, and the failing day in a file."""

try:
    from homebot.testing.strategies.days import days, saved_if_failing
    from homebot.testing.strategies.houses import houses
except ModuleNotFoundError as exc:
    if exc.name != "hypothesis":
        raise
    raise ImportError("random houses and days need hypothesis: pip install 'homebot[testing]'") from exc

__all__ = ["days", "houses", "saved_if_failing"]
