"""A fuzzing failure as files."""
