"""Whole runs of a pipeline on a mesh."""

from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast, with_simplices
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.work.session import Workspace


def optimized(one, with_data=True, **request):
    """The mesh after a whole run."""
    plan = plan_for(Request(**request), one.dimension())
    return job.optimize(one, plan.pipeline, plan.measure, with_data=with_data).mesh


def worked_on(one, **request):
    """What a pipeline makes of a mesh: as cast, as worked on, and as put together again."""
    before = cast(one)
    plan = plan_for(Request(**request), before.dimension)
    worked, origin = plan.pipeline.run(Workspace(before, plan.measure.judge)).work.result()
    return before, worked, with_simplices(one, worked, origin, before)
