"""Checks of a contour: joint limits, margins, distances between bodies, keep-out boxes; and remedies."""
