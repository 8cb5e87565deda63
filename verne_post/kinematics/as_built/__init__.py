"""The VERNE with its parts where they really are: six rods, guides and axes of their own."""
