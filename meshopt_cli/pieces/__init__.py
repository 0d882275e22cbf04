"""Meshes that are worked on piece by piece, each in a file of its own.

No process holds more than a piece, and what the others give of theirs. Where the pieces meet they
stay as they are; then the pieces give cells to each other, so that these places come to lie inside,
and what is near them is worked on.
"""
