"""homie."""
