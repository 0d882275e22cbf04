"""`python -m meshopt_cli`."""

from .cli.entry import run

if __name__ == "__main__":
    run()
