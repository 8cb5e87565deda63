"""A program is checked without making setpoints; the summary has the machining time."""

from verne_post.app.assemble import assemble
from verne_post.app.convert import setpoint_blocks
from verne_post.app.machined import judge_blocks, load_part
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
            body, report = load_part(program), progress if team.leads else None
            plan = plan_or_refuse(source, program, report)
            blocks = [] if body is None else [block for block, _move in setpoint_blocks(plan, fmt)]
            part = judge_blocks(program, body, blocks, report)
        except InputError as error:
            return refused(error)
        findings = (*plan.findings, *(() if part is None else part.findings))
        return Result(findings, summarise(source, plan, fmt, None, part), part=part)
