"""One pixel's way through the algorithm, step by step, and the lecture's exercises."""
