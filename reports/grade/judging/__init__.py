"""One submission judged on the scenes of an assignment, and the marks that it earns."""
