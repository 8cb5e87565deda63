"""Moves -> ToolPath: geometry of the programmed pieces in the table frame."""
