"""The experiments of the data sheet, one file each."""
