"""What the command line can do, a file for each group of commands. Heavy imports are inside the functions."""
