"""What a sequence shows: a street, or any MuJoCo model."""
