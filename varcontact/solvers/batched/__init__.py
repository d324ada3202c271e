"""Many small tangential problems at once, by a batched Newton method."""
