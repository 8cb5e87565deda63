"""Calibration of the machine as built: readings of the tool against the table -> deviations of its parts."""
