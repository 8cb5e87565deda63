"""Warnings about programs and set-ups that can run and are probably not meant so."""
