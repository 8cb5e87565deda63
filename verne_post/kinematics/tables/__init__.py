"""One file a kind of table: frame changes and the meaning of program coordinates on it."""
