"""How the tables of a history came to be, step by step; each file in `versions/` is one step."""
