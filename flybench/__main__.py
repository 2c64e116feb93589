"""The command: `flybench`, or `python -m flybench`."""

import sys


def main() -> None:
    """Run the command, or print the name of the library that is missing."""
    try:
        from scenarios.cli import main as run
    except ModuleNotFoundError as error:
        library = str(error.name).partition(".")[0]
        sys.exit(
            f"flybench: the command needs the library {library}, which is not installed. "
            "Install all that it needs with: pip install 'flybench[all]'"
        )
    run()


if __name__ == "__main__":
    main()
