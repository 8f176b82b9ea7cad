"""The command `minirt`."""
