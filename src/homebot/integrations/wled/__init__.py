"""wled."""
