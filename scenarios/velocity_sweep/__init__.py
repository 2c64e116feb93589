"""Velocity sweeps: estimates and truth at several angular velocities, and GRMS against speed."""
