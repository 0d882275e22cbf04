"""Changes to files, at random: of bytes, of lines, of words, and of numbers."""

from __future__ import annotations

import random
import re

# What counts, sizes and coordinates may be made into.
WORDS = [
    b"0", b"-1", b"1", b"2", b"7", b"255", b"65536", b"1000000", b"2147483647", b"2147483648",
    b"4294967296", b"9223372036854775807", b"9223372036854775808", b"-9223372036854775808",
    b"1" * 40, b"9" * 5000, b"1e308", b"1e400", b"-1e-320", b"nan", b"inf", b"-inf", b"0x10",
    b"1_0", b"1.5", b"+3", b"1e3", b"--", b"", b"a", b"\xe9", b"\xc2\xb2", b"\x1b[31m", b"\x07",
    b"%s", b"\0", b"End", b"$EndNodes", b"$Elements", b"CELLS", b"POINTS", b"LOOKUP_TABLE",
    b"METADATA", b"Vertices", b"Tetrahedra", b"DataArray", b"<", b"/>", b"&", b"&lt;",
    b"<!DOCTYPE a>", b'"',
]  # fmt: skip
# The same for whole numbers of binary files.
COUNTS = [0, 1, 2, 3, 4, 15, 16, 255, 256, 10**6, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**62,
          2**63 - 1, 2**63, 2**64 - 1]  # fmt: skip
_WORD = re.compile(rb"[^\s<>\"']+")
_NUMBER = re.compile(rb"-?\d[\d.eE+-]*")


def mutated(dice: random.Random, data: bytes, others: list[bytes]) -> bytes:
    """A file after some changes; the more, the rarer."""
    for _ in range(dice.choice((1, 1, 1, 1, 1, 1, 2, 2, 3, 8))):
        data = dice.choice(CHANGES)(dice, data, others)[: 1 << 20]
    return data


def _place(dice: random.Random, data: bytes) -> int:
    """Somewhere, more often near the start, where most is said of all the rest."""
    return int(len(data) * dice.random() ** dice.choice((1, 1, 3)))


def flip_bit(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    at = _place(dice, data)
    return data[:at] + bytes([data[at] ^ 1 << dice.randrange(8)]) + data[at + 1 :] if data else data


def set_byte(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    at = _place(dice, data)
    return data[:at] + bytes([dice.choice((0, 1, 10, 27, 32, 45, 127, 128, 255))]) + data[at + 1 :]


def cut(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    return data[: dice.randint(0, len(data))]


def drop(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    at = _place(dice, data)
    return data[:at] + data[at + dice.choice((1, 2, 4, 8, 100)) :]


def double(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    at = _place(dice, data)
    size = dice.choice((1, 4, 8, 50, 500))
    return data[:at] + data[at : at + size] * dice.choice((2, 2, 3, 100)) + data[at + size :]


def splice(dice: random.Random, data: bytes, others: list[bytes]) -> bytes:
    other = dice.choice(others)
    at = _place(dice, other)
    part = other[at : at + dice.choice((10, 100, 1000))]
    return data[: (to := _place(dice, data))] + part + data[to + dice.choice((0, len(part))) :]


def swap_lines(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    lines = data.split(b"\n")
    i, j = (dice.randrange(len(lines)) for _ in range(2))
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def drop_line(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    lines = data.split(b"\n")
    del lines[dice.randrange(len(lines))]
    return b"\n".join(lines)


def _with(dice: random.Random, data: bytes, pattern: re.Pattern[bytes]) -> bytes:
    found = list(pattern.finditer(data[: 1 << 16]))
    if not found:
        return data
    one = found[int(len(found) * dice.random() ** dice.choice((1, 2)))]
    return data[: one.start()] + dice.choice(WORDS) + data[one.end() :]


def other_word(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    return _with(dice, data, _WORD)


def other_number(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    return _with(dice, data, _NUMBER)


def other_count(dice: random.Random, data: bytes, _: list[bytes]) -> bytes:
    """A number in a binary file, at any place."""
    size = dice.choice((4, 8))
    value = dice.choice(COUNTS) % 256**size
    at = _place(dice, data)
    return data[:at] + value.to_bytes(size, dice.choice(("little", "big"))) + data[at + size :]


CHANGES = (flip_bit, set_byte, cut, drop, double, splice, swap_lines, drop_line, other_word,
           other_number, other_number, other_count, other_count)  # fmt: skip
