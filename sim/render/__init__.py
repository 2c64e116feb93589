"""MuJoCo's Filament renderer, whose images are read in cd/m², and its demands on the machine."""
