"""Calibration: lengths from measured poses, files of readings, and the first motion of a machine axis by axis."""
