"""The street and everything in it, as a MuJoCo model with lights and moving objects."""
