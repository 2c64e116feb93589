"""The fits: each estimates parameters of a sensor from one kind of evidence."""
