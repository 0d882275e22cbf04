"""Run cases by their numbers: `python tests/fuzz/one.py NUMBER...`, or `--batch FIRST N`."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS.parent), str(TESTS)]

from fuzz.harness import Case, limited, try_case  # noqa: E402
from fuzz.seeds import seeds  # noqa: E402


def main(words: list[str]) -> None:
    """Print what came of each case, a line of JSON each."""
    is_batch = words[0] == "--batch"
    numbers = [int(word) for word in words[is_batch:]]
    if is_batch:
        numbers = list(range(numbers[0], sum(numbers)))
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    seeds()
    try_case(Case(-1), folder)  # imports what there is to import
    with limited():
        for number in numbers:
            wrong, status, seconds = try_case(Case(number), folder)
            told = {"case": number, "wrong": wrong, "status": status, "seconds": round(seconds, 3)}
            print(json.dumps(told), flush=True)
    if is_batch:
        for path in folder.iterdir():
            path.unlink()
        folder.rmdir()
    else:
        print(folder)


if __name__ == "__main__":
    main(sys.argv[1:])
