"""JointPath -> motion profiles -> setpoints."""
