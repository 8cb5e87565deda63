"""What flows between the rooms: frozen tables, the machine, findings, and the protocols."""
