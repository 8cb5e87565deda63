"""RS274/NGC, block by block, in LinuxCNC's order of execution; Fanuc's language, which differs in words and traits."""
