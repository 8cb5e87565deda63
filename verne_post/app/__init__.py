"""The application layer: what commands and the Python API do with a program. It joins the packages below; no terminal, no files."""
