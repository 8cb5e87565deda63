"""JointPath -> time laws -> setpoints."""
