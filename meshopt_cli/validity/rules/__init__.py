"""The rules: importing this package fills `RULES`, in the order of the codes."""

from . import content, shape, conformity, domain, constraint, gates  # isort: skip

FILLED = (content, shape, conformity, domain, constraint, gates)
