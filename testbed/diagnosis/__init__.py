"""Where prediction and measurement disagree, which named effect explains it, and what is left with it added."""
