"""The application layer: what commands and the Python API do with a program. No terminal, no files."""
