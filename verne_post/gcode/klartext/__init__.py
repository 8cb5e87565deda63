"""Heidenhain Klartext: statements, Q parameters, path functions, planes and cycles, on the interpreter's state."""
