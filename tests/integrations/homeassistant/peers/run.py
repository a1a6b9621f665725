"""Runs inside Home Assistant's venv: Home Assistant with the configuration in a folder, and nothing beside it."""

import sys

from homeassistant import bootstrap, runner

for name in ("CRITICAL_INTEGRATIONS", "DEFAULT_INTEGRATIONS", "DEFAULT_INTEGRATIONS_NON_SUPERVISOR"):
    setattr(bootstrap, name, set())  # the frontend and what it needs: a third of an hour of installation
sys.exit(runner.run(runner.RuntimeConfig(config_dir=sys.argv[1], skip_pip=True)))
