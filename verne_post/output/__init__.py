"""Everything that becomes bytes: setpoint files, findings, dumps, summaries."""
