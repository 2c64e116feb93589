"""Output of the commands: files, folders, tables, figures, HTML pages and the terminal."""
