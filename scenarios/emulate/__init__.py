"""Events from anybody's pictures: `flybench emulate`."""
