"""Fuzzing campaigns: run, told in words, and their failures as files."""
