"""APT cutter location text: statements, and the blocks that they stand for."""
