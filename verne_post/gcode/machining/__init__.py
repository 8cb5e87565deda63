"""The machining core that every language holds: frames, tools, auxiliary functions and motion of one program.

It is given places in the active frame (mm, degrees), feed rates and geometry that is already decided. It knows no word,
no unit, no G90 and no label: a language turns words into its operations, keeps its own modes, and reports findings
about words in its own words. The core refuses what only the core can know: a position is unknown, a contour cannot be
reached, the tool is tilted.
"""
