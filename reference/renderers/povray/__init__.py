"""POV-Ray 3.7."""
