"""The words of rules: triggers, conditions and steps, for routines, goals, habits and imported automations. Pure."""
