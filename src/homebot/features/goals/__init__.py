"""Goals in words that become plans: facts of the house, operators on it, a planner, and the steps with outcomes."""
