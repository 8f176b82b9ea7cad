"""A scene in POV-Ray's language."""
