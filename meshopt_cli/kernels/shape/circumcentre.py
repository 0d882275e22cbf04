"""Circumcentres, with the measure of the simplex that they need anyway."""

from __future__ import annotations

from ...compiled.decorators import inlined
from ..vectors import Vec, cross, dot, minus


@inlined
def tri_circumcentre(a: Vec, b: Vec, c: Vec) -> tuple[Vec, float]:
    """Circumcentre of a triangle of the plane, and twice its area; not finite for a flat one."""
    u = minus(b, a)
    v = minus(c, a)
    area = u.x * v.y - u.y * v.x
    uu = dot(u, u) / (2.0 * area)
    vv = dot(v, v) / (2.0 * area)
    return Vec(a.x + uu * v.y - vv * u.y, a.y + vv * u.x - uu * v.x, 0.0), area


@inlined
def tet_circumcentre(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[Vec, float]:
    """Circumcentre of a tetrahedron, and six times its volume; not finite for a flat one."""
    u = minus(b, a)
    v = minus(c, a)
    w = minus(d, a)
    vw = cross(v, w)
    wu = cross(w, u)
    uv = cross(u, v)
    volume = dot(u, vw)
    uu = dot(u, u) / (2.0 * volume)
    vv = dot(v, v) / (2.0 * volume)
    ww = dot(w, w) / (2.0 * volume)
    return Vec(
        a.x + uu * vw.x + vv * wu.x + ww * uv.x,
        a.y + uu * vw.y + vv * wu.y + ww * uv.y,
        a.z + uu * vw.z + vv * wu.z + ww * uv.z,
    ), volume
