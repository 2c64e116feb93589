"""A spiking network with synaptic delays (Orchard et al., 2013)."""
