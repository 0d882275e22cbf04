"""The arrays of a file of VTK with XML: text, base64 or raw bytes, in place or appended."""

from __future__ import annotations

import binascii
import importlib
import zlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...mesh.model import Array
from ..sniff import UnreadableError
from ..text import numbers
from .tree import Element

_BYTES = (1, 2, 4, 8)
KINDS = {f"Int{8 * n}": f"i{n}" for n in _BYTES} | {f"UInt{8 * n}": f"u{n}" for n in _BYTES}
KINDS |= {"Float32": "f4", "Float64": "f8"}
_BIT = "Bit"
_SKIPPED = "String"
# A row of coordinates, or of vertices, that differs from the others takes a bit at least,
# however it is compressed.
_ROWS_A_BYTE = 8
_LZMA_MEMORY = 1 << 28  # bytes, four times what the highest level takes

# What may come out of all arrays of a file: so many bytes, or so many times what is in it.
_LEAST_MOST = 1 << 28
_MOST_TIMES = 1000

Decompress = Callable[[bytes | memoryview, int], bytes]


def _zlib(block: bytes | memoryview, size: int) -> bytes:
    return zlib.decompressobj().decompress(block, size + 1)


def _lzma(block: bytes | memoryview, size: int) -> bytes:
    import lzma

    try:
        return lzma.LZMADecompressor(memlimit=_LZMA_MEMORY).decompress(block, size + 1)
    except lzma.LZMAError:
        raise ValueError from None


def _lz4(block: bytes | memoryview, size: int) -> bytes:
    try:
        library = importlib.import_module("lz4.block")
    except ImportError:
        raise UnreadableError(
            "it is compressed by LZ4, for which a library is missing: pip install lz4"
        ) from None
    try:
        unpacked: bytes = library.decompress(block, uncompressed_size=size)
    except library.LZ4BlockError:
        raise ValueError from None
    return unpacked


class _Compressor(NamedTuple):
    """How blocks are unpacked, and to how many times their size at most."""

    unpack: Decompress
    most: int


COMPRESSORS = {
    "vtkZLibDataCompressor": _Compressor(_zlib, 1040),
    "vtkLZMADataCompressor": _Compressor(_lzma, 10000),
    "vtkLZ4DataCompressor": _Compressor(_lz4, 260),
}


class Decoder:
    """Reads the arrays of one file.

    Parameters
    ----------
    data : bytes
        The whole file.
    root : Element
        Says the order of bytes, the size of counts and the compressor.
    appended : bytes-like
        The appended data.
    """

    def __init__(self, data: bytes, root: Element, appended: bytes | memoryview):
        self.data = data
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.head = np.dtype(self.order + KINDS.get(root.get("header_type", "UInt32"), "u4"))
        self.compressor = None
        self.unpacked = 0  # bytes, of all arrays
        if name := root.get("compressor"):
            if name not in COMPRESSORS:
                raise UnreadableError(f"it is compressed by {name}, which is not supported")
            self.compressor = COMPRESSORS[name]
        self.appended = appended
        last = root.first("AppendedData")
        self.appended_raw = last is not None and last.get("encoding") == "raw"

    def array(self, element: Element, n: int | None, distinct: int = 0) -> Array | None:
        """Read an array.

        Parameters
        ----------
        n : int, optional
            How many rows it must have; any number without.
        distinct : int
            At least so many of the rows must differ, or else the count is not believed.

        Returns
        -------
        (n,) or (n, k) array, or None for strings

        Raises
        ------
        UnreadableError
            It is not all there, or of an unknown type.
        """
        name, kind = element.get("Name", "without a name"), element.get("type")
        width = max(element.count("NumberOfComponents", "1"), 1)
        if kind == _SKIPPED or element.tag == "Array":
            return None
        if kind not in KINDS and kind != _BIT:
            raise UnreadableError(f"the array {name} has values of the unknown type {kind!r}")
        size = None if n is None else n * width
        try:
            values = self._values(element, kind, size, distinct)
        except (zlib.error, EOFError, RuntimeError, OverflowError, ValueError) as error:
            if isinstance(error, UnreadableError):
                raise UnreadableError(f"the array {name}: {error}") from None
            raise UnreadableError(f"the array {name} is truncated or damaged") from None
        if size is not None and len(values) != size:
            cut = "truncated: " * (len(values) < size)
            raise UnreadableError(f"{cut}the array {name} has {len(values)} values, not {size}")
        if len(values) % width:
            raise UnreadableError(f"the array {name} has no whole rows of {width} values")
        return values.reshape(-1, width) if width > 1 else values

    def _values(self, element: Element, kind: str, size: int | None, distinct: int) -> Array:
        dtype = np.dtype(self.order + KINDS.get(kind, "u1"))
        form = element.get("format", "ascii")
        body: bytes | memoryview
        if form == "ascii":
            return _parsed(self.data[element.start : element.end], dtype)
        if form == "appended":
            at = element.count("offset")
            if at > len(self.appended):
                raise UnreadableError("truncated: it starts behind the end of the appended data")
            body, raw = self.appended[at:], self.appended_raw
        elif form == "binary":
            body, raw = self.data[element.start : element.end].translate(None, b" \t\r\n"), False
        else:
            raise UnreadableError(f"its format is {form!r}, which is not supported")
        source = _Raw(body) if raw else _Base64(body)
        n_bytes = None if size is None else size * dtype.itemsize
        if n_bytes is not None and kind == _BIT:
            n_bytes = -(-n_bytes // 8)
        unpack = self._compressed if self.compressor else self._plain
        packed = unpack(source, n_bytes, distinct)
        if kind == _BIT:
            return np.unpackbits(np.frombuffer(packed, np.uint8))[:size]
        if len(packed) % dtype.itemsize:
            raise UnreadableError("it ends in the middle of a value")
        return np.frombuffer(packed, dtype)

    def _plain(
        self, source: _Raw | _Base64, n_bytes: int | None, distinct: int
    ) -> bytes | memoryview:
        """Bytes after their number."""
        (size,) = self._counts(source, 1)
        source.next_part(always=False)
        packed = source.take(size)
        if len(packed) < size:
            raise UnreadableError(f"truncated: it has {len(packed)} bytes of {size}")
        return packed

    def _counts(self, source: _Raw | _Base64, n: int) -> list[int]:
        """Look at the first n counts, and go past them."""
        found = np.frombuffer(source.take(n * self.head.itemsize), self.head)
        if len(found) < n:
            raise UnreadableError("truncated: it has not all its counts")
        return [int(count) for count in found]

    def _compressed(
        self, source: _Raw | _Base64, n_bytes: int | None, distinct: int
    ) -> Array | bytes:
        """Unpack blocks: their number, size, that of the last, and their sizes packed."""
        assert self.compressor is not None
        start = source.at
        (n,) = self._counts(source, 1)
        if n == 0:
            return b""
        if n * self.head.itemsize > source.left:
            raise UnreadableError(f"truncated: it should have {n} blocks")
        source.at = start  # counts and blocks are coded apart, the counts as a whole
        _, size, last, *packed = self._counts(source, 3 + n)
        source.next_part(always=True)
        if distinct > _ROWS_A_BYTE * (sum(packed) + _ROWS_A_BYTE):
            raise UnreadableError(f"{distinct} rows, all different, cannot be in so few bytes")
        sizes = [size] * (n - 1) + [last or size]
        if any(sizes[i] > self.compressor.most * (packed[i] + 8) for i in range(n)):
            raise UnreadableError("its blocks cannot be as large as it says")
        if sum(packed) > source.left:
            raise UnreadableError(f"truncated: it has {source.left} bytes of {sum(packed)}")
        whole = source.take(sum(packed))
        if n_bytes not in (None, sum(sizes)):
            raise UnreadableError(f"it has {sum(sizes)} bytes, and not {n_bytes}")
        self.unpacked += sum(sizes)
        if self.unpacked > max(_LEAST_MOST, _MOST_TIMES * len(self.data)):
            raise UnreadableError("more comes out of its arrays than can be believed")
        result = np.empty(sum(sizes), np.uint8)
        at = done = 0
        for size, n_packed in zip(sizes, packed, strict=True):
            block = self.compressor.unpack(whole[at : at + n_packed], size)
            if len(block) != size:
                raise UnreadableError("a block of it is damaged")
            result[done : done + size] = np.frombuffer(block, np.uint8)
            at, done = at + n_packed, done + size
        return result


class _Raw:
    """Bytes as they are."""

    def __init__(self, body: bytes | memoryview):
        self.body = memoryview(body)
        self.at = 0

    @property
    def left(self) -> int:
        """How many bytes follow, at most."""
        return len(self.body) - self.at

    def take(self, n: int) -> memoryview:
        """The next n bytes, or those that there are."""
        part = self.body[self.at : self.at + n]
        self.at += len(part)
        return part

    def next_part(self, always: bool) -> None:
        """Go to where the next part starts, which here follows at once."""


class _Base64:
    """Bytes in base64, three of them in four letters; parts may be coded apart."""

    def __init__(self, body: bytes | memoryview):
        self.letters = memoryview(body)
        self.at = 0  # bytes of this part that were taken

    @property
    def left(self) -> int:
        """How many bytes follow, at most."""
        return len(self.letters) // 4 * 3 - self.at

    def take(self, n: int) -> memoryview:
        """The next n bytes, or those that there are."""
        first, last = self.at // 3, -(-(self.at + n) // 3)
        decoded = memoryview(binascii.a2b_base64(self.letters[4 * first : 4 * last]))
        part = decoded[self.at - 3 * first :][:n]
        self.at += len(part)
        return part

    def next_part(self, always: bool) -> None:
        """Go to where the next part starts, if this one has ended or in any case."""
        n_letters = 4 * -(-self.at // 3)
        padding = bytes(self.letters[max(n_letters - 2, 0) : n_letters]).count(b"=")
        if always or (padding and n_letters // 4 * 3 - padding == self.at):
            self.letters = self.letters[n_letters:]
            self.at = 0


def _parsed(text: bytes, dtype: np.dtype) -> Array:
    wide = {"f": np.float64, "u": np.uint64 if dtype.itemsize == 8 else np.int64, "i": np.int64}
    values = numbers(text, wide[dtype.kind])
    narrow = values.astype(dtype.newbyteorder("="))
    return narrow if dtype.kind == "f" or np.array_equal(narrow, values) else values
