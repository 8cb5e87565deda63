"""What every package may use, whatever the machine: units, tolerances, arrays, splines, numbers as text, processes."""
