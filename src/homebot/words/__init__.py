"""The only reader of what people write: tokens, times, names, and small grammars over them. Pure."""
