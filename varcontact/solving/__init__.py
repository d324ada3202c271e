"""Solution of a scene: plan, contact problems, Panagiotopoulos's loop, time steps."""
