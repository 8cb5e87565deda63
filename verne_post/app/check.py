"""A program is checked without making setpoints; the summary has the machining time."""

from verne_post.app.assemble import assemble
from verne_post.app.plan import plan_or_refuse
from verne_post.app.result import Progress, Result, refused
from verne_post.app.row_format import format_of
from verne_post.app.summary import summarise
from verne_post.base.long_text import Text
from verne_post.base.team import work_together
from verne_post.model.findings import InputError
from verne_post.model.machine import Machine
from verne_post.model.options import Options


def check_source(
    source: Text, machine: Machine, options: Options | None = None, progress: Progress | None = None
) -> Result:
    """Check a program against every limit, and plan it.

    Returns
    -------
    Result
        Never raises for bad input; see ``findings`` and ``exit_code``.

    Raises
    ------
    UsageError
        Options that no program can have.
    """
    options = options or Options()
    with work_together(options.jobs) as team:
        try:
            program = assemble(source, machine, options, team)
            fmt = format_of(machine, options, program.cycle)
            plan = plan_or_refuse(source, program, progress if team.leads else None)
        except InputError as error:
            return refused(error)
        return Result(plan.findings, summarise(source, plan, fmt, None))
