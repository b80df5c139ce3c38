"""Output folders of the commands: written under a temporary name, and renamed when complete."""
