"""The scene file: its text, schema, validation, and what loading makes of it (`load.py`)."""
