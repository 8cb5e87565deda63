"""Checks of a contour: joint limits and margins, distances between bodies, keep-out boxes, and what would remove a violation."""
