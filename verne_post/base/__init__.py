"""Units, tolerances and rotations: what every room may use."""
