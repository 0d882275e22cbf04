"""Whole runs of a pipeline on a mesh."""

from meshopt_cli.boundary.policy import Fixed
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast, with_simplices
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.work.session import Workspace


def optimized(one, policy=None, with_data=True, **request):
    """The mesh after a whole run; its boundary is fixed where no policy is given."""
    plan = plan_for(Request(**request), one.dimension())
    policy = Fixed() if policy is None else policy
    return job.optimize(one, plan.pipeline, plan.measure, with_data=with_data, policy=policy).mesh


def worked_on(one, **request):
    """What a pipeline makes of a mesh: as cast, as worked on, and as put together again."""
    before = cast(one)
    plan = plan_for(Request(**request), before.dimension)
    worked, origin = plan.pipeline.run(Workspace(before, plan.measure.judge)).work.result()
    return before, worked, with_simplices(one, worked, origin, before)
