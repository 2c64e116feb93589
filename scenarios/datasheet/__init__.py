"""A sensor's data sheet, as a page, as numbers and in the terminal."""
