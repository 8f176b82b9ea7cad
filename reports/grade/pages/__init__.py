"""The graded class as pages, tables and files for other programs."""
