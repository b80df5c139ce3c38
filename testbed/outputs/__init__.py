"""The output of a command: run folders, written beside their place and renamed into it when complete."""
