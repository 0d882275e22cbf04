"""`python -m meshopt_cli`."""

from .cli.main import run

if __name__ == "__main__":
    run()
