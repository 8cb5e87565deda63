"""Check setpoints as they are written, by code that shares nothing with planning."""
