"""What would bring a refused program within limits; each remedy is tried on the program before it is reported."""
