"""Judges setpoints as they are written. Believes nothing but the numbers; shares no code with timing."""
