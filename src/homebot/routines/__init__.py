"""For apps that earlier versions exported from routines."""
