"""Mitsuba 3, in Python and as its own command."""
