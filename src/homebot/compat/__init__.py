"""Programs written for other frameworks, on homebot's graph."""
