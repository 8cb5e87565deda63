"""The parallel module of the VERNE: closed-form solutions, all modes, rods, loop equations for identification."""
