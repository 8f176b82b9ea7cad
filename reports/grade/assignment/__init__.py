"""An assignment: the rubric, its scenes and their hidden variants, the submission times."""
