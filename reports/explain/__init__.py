"""One pixel, explained for people."""
