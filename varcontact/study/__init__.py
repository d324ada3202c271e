"""Studies: many solves, side by side or one after the other."""
