"""Moves -> ToolPath: geometry of the programmed segments in the table frame."""
