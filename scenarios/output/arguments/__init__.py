"""The arguments of the command line: groups in the help, and options that all commands have."""
