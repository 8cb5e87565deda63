"""The report page: a program looked at from all sides, as one HTML file or picture."""
