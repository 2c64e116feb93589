"""MuJoCo's Filament renderer, read in cd/m², and what it needs from the machine."""
