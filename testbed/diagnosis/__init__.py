"""Where prediction and measurement disagree, which named effect explains it, and the remaining residual."""
