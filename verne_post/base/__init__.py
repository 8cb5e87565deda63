"""Units, tolerances and rotations: what every package may use."""
