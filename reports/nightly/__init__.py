"""Nightly runs: verify, fuzz, mutants; resumable after an interruption, with a landing page."""
