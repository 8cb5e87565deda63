"""A machine file as commands of calibration need it: its bytes, the machine in use, and its as-built kinematics."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from verne_post.cli.common import load, require_positive
from verne_post.cli.files import RunFiles

if TYPE_CHECKING:
    from verne_post.base.arrays import Array
    from verne_post.calibration.as_built.workspace import WorkspacePoses
    from verne_post.kinematics.as_built.machine import AsBuiltMachine
    from verne_post.model.machine import Machine

#: Tools of a plan or a study where nobody names any, mm.
TOOL_LENGTHS: Final = (60.0, 160.0)
#: Poses over the workspace at which errors are evaluated.
EVALUATED_POSES: Final = 1000


class OpenedMachine:
    """A machine file with its bytes: the machine in use, and the same with its as-built kinematics."""

    def __init__(self, files: RunFiles, name: str) -> None:
        from verne_post.calibration.as_built.machine_text import take_as_built_route
        from verne_post.config.kinds import AS_BUILT_KINDS
        from verne_post.config.machine_paths import find_machine_path

        self.path = find_machine_path(name)
        self.present: Machine = load(files, name)
        if self.present.kind not in AS_BUILT_KINDS:
            raise click.UsageError(
                f"{name}: this command works only for machines of kind {' or '.join(AS_BUILT_KINDS)}; this one is "
                f"{self.present.describe_kind()}"
            )
        self.raw = files.read(self.path, "--machine")
        route = take_as_built_route(self.present, self.raw, self.path.name)
        self.machine: Machine = route[0]
        self.as_built: AsBuiltMachine = route[1]

    def make_text(self, deviations: "Array", source: str) -> str:
        """The machine file with other deviations (58,)."""
        from verne_post.calibration.as_built.machine_text import write_machine_text
        from verne_post.model.deviations import Deviations

        return write_machine_text(self.raw, Deviations.build_from_vector(deviations), source, self.path.name)

    @staticmethod
    def open_like(files: RunFiles, name: str) -> "AsBuiltMachine":
        """The as-built kinematics of another machine."""
        from verne_post.kinematics.as_built.machine import AsBuiltMachine

        other = load(files, name, "--simulate").five_axis
        if not isinstance(other, AsBuiltMachine):
            raise click.UsageError(f"--simulate {name}: has no [as_built]; machine perturb makes such a file")
        return other

    @staticmethod
    def require_sound(text: str, output: Path) -> None:
        """Refuse the text of a machine file that could not be loaded."""
        from verne_post.config.load import build_machine

        build_machine(text.encode(), output.name)

    @staticmethod
    def choose_lengths(given: tuple[float, ...]) -> tuple[float, ...]:
        """Tool lengths of an option."""
        for value in given:
            require_positive("--tool-length", value, zero=True)
        return given or TOOL_LENGTHS

    def sample_workspace(self, lengths: tuple[float, ...]) -> "WorkspacePoses":
        """Poses all over the workspace."""
        import numpy as np

        from verne_post.calibration.as_built.workspace import sample_workspace

        try:
            return sample_workspace(self.machine, EVALUATED_POSES, lengths, np.random.default_rng(0))
        except ValueError as error:
            raise click.UsageError(f"tools of {', '.join(f'{length:g}' for length in lengths)} mm: {error}") from None

    def choose_tolerances(self, lengths: float | None, directions: float | None) -> "Array":
        """Standard deviations of manufacture (58,), mm and rad."""
        import numpy as np

        from verne_post.base.units import MILLI
        from verne_post.model.deviations import IS_ANGLE

        found = np.array(self.machine.tolerances)
        for option, value, chosen, unit in (
            ("--tolerance-mm", lengths, ~IS_ANGLE, 1.0),
            ("--tolerance-mrad", directions, IS_ANGLE, MILLI),
        ):
            if value is not None:
                require_positive(option, value)
                found[chosen] = value * unit
        return found
