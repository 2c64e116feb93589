"""The experiments of the data sheet, one file each; `measure` in each returns its section."""
