"""`python -m flybench`: the command `flybench`."""

from scenarios.cli import main

if __name__ == "__main__":
    main()
