"""How well the events of a coarser rendering match those of the finest."""
