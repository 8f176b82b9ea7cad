"""What is wrong with an implementation that fails."""
