"""Scripts for developers of flybench."""
