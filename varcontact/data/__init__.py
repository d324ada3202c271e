"""Numbers that ship with the package, each beside the command that makes them."""
