"""From tool poses to joints and back, and every geometric check along the way."""
