"""From tool poses to joints and back, and every judgement of geometry along the way."""
