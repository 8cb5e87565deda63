"""One file a parallel module: geometry, inverse, forward, margins, nothing else."""
