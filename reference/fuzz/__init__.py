"""Random scenes: drawn, compared, and shrunk to the smallest that still fails the same way."""
