"""One folder for each maker or ecosystem, with all that is its own."""
