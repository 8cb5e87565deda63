"""The machined part: bodies of tools, meshes, and the distances between them while the tool moves."""
