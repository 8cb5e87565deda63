"""What every package may use, and nothing of machines: units, tolerances, rotations, arrays in blocks, splines, numbers as text, processes."""
