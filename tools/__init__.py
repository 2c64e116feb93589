"""Scripts for those who work on flybench itself."""
