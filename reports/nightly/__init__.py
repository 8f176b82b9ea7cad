"""A night: verify, fuzz, mutants, and what is left behind; resumable after a kill."""
