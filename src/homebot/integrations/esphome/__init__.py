"""esphome."""
