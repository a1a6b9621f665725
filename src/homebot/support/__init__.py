"""Small modules that several packages use and users do not import."""
