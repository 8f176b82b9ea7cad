"""POV-Ray 3.7, through its program."""
