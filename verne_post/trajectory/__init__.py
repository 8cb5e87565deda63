"""JointPath -> time profiles -> setpoints."""
