"""The report: one program as an HTML page or a picture."""
