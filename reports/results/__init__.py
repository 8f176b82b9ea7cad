"""The record of a run, and everything derived from it."""
