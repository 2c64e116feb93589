"""How things move, in closed form: trajectories, gait, camera shake and sample times."""
