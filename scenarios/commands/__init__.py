"""The commands of `flybench`, one file each."""
