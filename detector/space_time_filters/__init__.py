"""Space-time filters with divisive normalisation (Brosch et al., 2015)."""
