"""The house for agents and scripts: find, command, why and history, as small JSON over HTTP."""
