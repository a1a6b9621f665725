"""The table ``[notify]`` of the configuration."""

from __future__ import annotations

from homebot.apps.notifier import NotifySettings
from homebot.config import Config, Table, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.plugins import check_extra
from homebot.support.similar import did_you_mean

__all__ = ["read_notify"]


def read_notify(config: Config, table: Table) -> NotifySettings:
    """Return where notifications of apps go.

    Raises:
        ConfigError: A key is wrong, no such gateway is configured, or the extra is missing.
    """
    settings = parse_settings(NotifySettings, table, config.source, "notify", config.folder)
    if settings.address and settings.gateway not in config.gateways:
        problem = f"there is no gateway {settings.gateway!r} that could publish notifications"
        hint = did_you_mean(settings.gateway, config.gateways, "name one, or give urls of apprise")
        raise ConfigError(config.source, "notify.gateway", f"{problem}; {hint}")
    if settings.urls:
        try:
            check_extra("[notify] with urls", "apprise", "apprise")
        except UsageError as exc:
            raise ConfigError(config.source, "notify.urls", str(exc)) from exc
    return settings
