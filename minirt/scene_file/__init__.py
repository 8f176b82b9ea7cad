"""A scene's JSON: its schema, its text, its validation."""
