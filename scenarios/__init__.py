"""What people run: the commands, and all that knows every stage at once."""
