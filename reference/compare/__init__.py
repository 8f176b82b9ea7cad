"""How two frames are compared: the error model, stability, and each quantity's comparison."""
