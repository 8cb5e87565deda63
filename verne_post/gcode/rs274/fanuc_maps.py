"""Scaling (G51), mirror images (G51.1) and polar coordinates (G16) of Fanuc: words become those of the work system."""

import math
from typing import Any, Final

from msgspec.structs import replace

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, TAKES_AXES, spell_g_code
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.fanuc_codes import MIRROR, MIRROR_OFF, OF_FRAMES, SCALE_OFF
from verne_post.gcode.rs274.modes import NO_MAPS, AxisMaps, Modes
from verne_post.gcode.rs274.values import WordValues

#: Factors of scaling, as controls bound them.
_LEAST, _MOST = 1e-3, 1e3
#: Two factors of one size to within this share.
_SAME: Final = 1e-9
_ARCS: Final = (20, 30)
_LINEAR: Final = "XYZ"
#: Codes that mean other places than a motion has: they need an end of the maps first.
_BARRED_CODES: Final = (*TAKES_AXES, 530, 62)


class FanucMaps:
    """G50, G51, G50.1, G51.1, G15 and G16."""

    def __init__(self, core: Machining, values: WordValues) -> None:
        self.core, self.values, self.state = core, values, core.state
        self.modes: Modes = core.state.modes

    def _set(self, maps: AxisMaps, **changes: Any) -> None:
        """Change what holds; :data:`NO_MAPS` itself where nothing does."""
        new_maps = replace(maps, **changes)
        is_end = replace(new_maps, centers=NO_MAPS.centers) == NO_MAPS
        self.modes.maps = NO_MAPS if is_end else new_maps

    # --- what holds --------------------------------------------------------------------------------

    def set_polar(self, on: bool) -> None:
        """G16, G15."""
        maps = self.modes.maps
        if on and (maps.factors, maps.mirrors) != (NO_MAPS.factors, NO_MAPS.mirrors):
            raise ProgramError("VP017", "G16 under G51 or G51.1; write G50 and G50.1 first")
        self._set(maps, polar=on)

    def set_scale(self, block: Block, code: int, text_has_point: bool) -> None:
        """G51 X Y Z P: all axes by one factor about a point; I J K: each axis by its own. G50 ends it."""
        words, maps, state = block.words, self.modes.maps, self.state
        self.core.refuse_compensation(spell_g_code(code))
        if code == SCALE_OFF:
            self._set(maps, factors=(1.0,) * 3)
            return
        if self.modes.turns or maps.polar or maps.factors != (1.0,) * 3:
            raise ProgramError(
                "VP017", "G51 under G51, G68 or G16; controls scale first, then turn; write G50, G69 or G15 before"
            )
        given = [letter for letter in "IJK" if letter in words]
        if ("P" in words) == bool(given):
            raise ProgramError("VP005", "G51 needs P, the factor of all axes, or I, J, K, those of X, Y, Z")
        if not text_has_point:
            letter = (given or ["P"])[0]
            raise block.error(
                "VP007",
                f"{letter}{words[letter]:g} without a decimal point: a parameter sets its unit; write {letter}2.0 for "
                "twice the size",
                letter,
            )
        factors = tuple(words.get(letter, words.get("P", 1.0)) for letter in "IJK")
        for letter, factor in zip("IJK", factors, strict=True):
            if not _LEAST <= abs(factor) <= _MOST:
                raise block.error(
                    "VP007",
                    f"a factor of {factor:g}: it lies between {_LEAST:g} and {_MOST:g}",
                    letter if letter in words else "P",
                )
        missing = [axis for axis, letter in enumerate(_LINEAR) if letter not in words and factors[axis] != 1.0]
        self.core.require_known(block, missing, "G51 about the place where the tool is")
        centers = tuple(
            self.values.read_axis_value(block, axis) if letter in words else state.position[axis]
            for axis, letter in enumerate(_LINEAR)
        )
        self._set(maps, factors=factors, centers=centers)

    def set_mirror(self, block: Block, code: int) -> None:
        """G51.1 X Y Z: mirror images about places of axes; G50.1 ends those of the axes that it names."""
        maps, name = self.modes.maps, spell_g_code(code)
        given = [axis for axis, letter in enumerate(_LINEAR) if letter in block.words]
        self.core.refuse_compensation(name)
        if not given:
            raise ProgramError("VP005", f"{name} needs the axes, X, Y or Z")
        if self.modes.turns or maps.polar or maps.factors != (1.0,) * 3:
            raise ProgramError(
                "VP017", f"{name} under G51, G68 or G16; controls mirror first: write G50, G69 or G15 before"
            )
        mirrors = list(maps.mirrors)
        for axis in given:
            mirrors[axis] = self.values.read_axis_value(block, axis) if code == MIRROR else None
        self._set(maps, mirrors=tuple(mirrors))

    # --- blocks ------------------------------------------------------------------------------------

    def convert(self, block: Block, codes: set[int]) -> int | None:
        """Convert a motion's words to the work system; returns the modal motion after the block if it changes.

        Raises
        ------
        ProgramError
            VP017: what cannot be under such maps.
        """
        maps, words, modes = self.modes.maps, block.words, self.modes
        if codes & {*TAKES_AXES, 530} and {*_LINEAR} & set(words):
            raise ProgramError(
                "VP017",
                f"{spell_g_code(min(codes & {*_BARRED_CODES}))} under G51, G51.1 or G16; write G50, G50.1 or G15 first",
            )
        motion = next((code for code in codes if code in (0, 10, *_ARCS, *CYCLES)), modes.motion)
        if codes & {*OF_FRAMES, MIRROR_OFF, SCALE_OFF} or motion is None or not set(words) & set("XYZIJKR"):
            return None
        if motion == 62 or modes.vectors:
            raise ProgramError("VP017", "G6.2 and tool vectors under G51, G51.1 or G16; write G50, G50.1 or G15 first")
        plane = next((code // 10 - 17 for code in codes if code in (170, 180, 190)), self.state.plane)
        absolute = 900 in codes or (modes.absolute and 910 not in codes)
        if maps.polar:
            self._convert_polar(block, plane, absolute, motion)
            return None
        unit = MM_PER_INCH if 200 in codes or (modes.inch and 210 not in codes) else 1.0
        u, v, normal, *_ = PLANES[plane]
        factors, shifts = zip(*(maps.find_map(axis) for axis in range(3)), strict=True)
        flips, size = factors[u] * factors[v] < 0, abs(factors[u])
        if motion in CYCLES and factors[normal] < 0:
            raise ProgramError(
                "VP017",
                f"{spell_g_code(motion)} under a mirror image of the drilling axis: the hole would be drilled from "
                "below",
            )
        for axis, letter in enumerate(_LINEAR):
            if letter in words:
                words[letter] = factors[axis] * words[letter] + (shifts[axis] / unit if absolute else 0.0)
            if motion in _ARCS and "IJK"[axis] in words:
                words["IJK"[axis]] *= factors[axis]
        if "R" in words and motion in CYCLES:
            words["R"] = factors[normal] * words["R"] + (shifts[normal] / unit if absolute else 0.0)
        if motion in _ARCS and {"I", "J", "K", "R"} & set(words):
            if not math.isclose(size, abs(factors[v]), rel_tol=_SAME):
                raise ProgramError(
                    "VP017",
                    "an arc under G51 with different factors of its axes would be an ellipse; let the CAM system "
                    "scale it",
                )
            if "R" in words:
                words["R"] *= size
        if not flips:
            return None
        self._flip(block, motion)
        return motion if motion in _ARCS else None

    @staticmethod
    def _flip(block: Block, motion: int) -> None:
        """Arcs and compensation of a mirror image go to the other side."""
        other = {2.0: 3.0, 3.0: 2.0, 41.0: 42.0, 42.0: 41.0}
        block.codes = [
            (letter, other.get(number, number) if letter == "G" else number, at) for letter, number, at in block.codes
        ]
        if motion in _ARCS and not any(letter == "G" and number in (2.0, 3.0) for letter, number, _at in block.codes):
            block.codes.append(("G", other[motion / 10], 0))

    def _convert_polar(self, block: Block, plane: int, absolute: bool, motion: int) -> None:
        """X is the distance from X0 Y0, and Y the angle; in G91 the angle alone counts from the last one."""
        words, columns = block.words, block.columns
        if not {"X", "Y"} & set(words):
            return
        if plane != 0:
            raise ProgramError("VP017", "G16 in G18 or G19 is not executed; write G17, or X Y Z")
        if motion in _ARCS and "R" not in words:
            raise ProgramError(
                "VP017", "an arc under G16 needs R: a centre would count from a place that the program does not name"
            )
        if not absolute and "X" in words:
            raise block.error(
                "VP002", "X under G16 in G91, a distance from where the tool is, is not executed; give it in G90", "X"
            )
        for letter, polar in (("X", "@"), ("Y", "^")):
            if letter in words:
                words[polar], columns[polar] = words.pop(letter), columns.pop(letter)
