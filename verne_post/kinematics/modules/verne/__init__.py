"""The parallel module of the VERNE: closed-form solutions, all modes, rod geometry, loop equations for identification."""
