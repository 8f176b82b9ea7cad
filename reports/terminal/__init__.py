"""What a person sees in the terminal, and where output goes."""
