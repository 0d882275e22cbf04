"""Handles of facets, and what stands in place of one where no neighbour is.

A handle packs a cell and a local number: `4 * cell + local`, in both dimensions. Beyond a facet
lies the handle of the same facet in the neighbour, or one of the borders below, all negative:
code that only asks whether there is a neighbour asks for the sign.
"""

OUTER = -1  # the boundary of the mesh: the facet bounds one cell only
INTERFACE = -2  # between two regions, each of which ends there; also shared by three cells or more
DECLARED = -3  # inside a region, and listed in the file, so that it must stay
# And all below down to RIM, as PATCH - p: the boundary of the mesh, in a patch p of facets that may
# change.
PATCH = -4
# And all below these, as RIM - i, while a sweep works in blocks: the i-th of the facets between two
# of them. Only `blocks` asks for these; to all else they are borders that stay.
RIM = -(2**40)
