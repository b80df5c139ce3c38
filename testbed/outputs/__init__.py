"""What a command leaves behind: run folders, written beside their place and renamed into it when complete."""
