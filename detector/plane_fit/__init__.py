"""Local plane fits to the surface of active events (Benosman et al., 2014)."""
