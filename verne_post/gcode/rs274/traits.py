"""Where controls that speak RS274/NGC differ in what the same codes do."""

from msgspec import Struct


class Traits(Struct, frozen=True, kw_only=True):
    """How a control executes codes that others have too; as LinuxCNC does unless a dialect says otherwise."""

    #: H0 and D0 are no offset, and D holds until the next tool change; else they are those of the tool in the
    #: spindle.
    zero_is_no_offset: bool = False
    #: The entry move of cutter compensation ends beside the start of the contour, not beside its own end.
    perpendicular_entry: bool = False
    begins_at_once: bool = True  #: Such a compensation begins with its first block, also without motion in the plane.
    diameter_codes: bool = True  #: G41.1 and G42.1 are there, which take the diameter itself.
    beside_spline: tuple[int, ...] = (52, 53, 900, 910)  #: G codes that may stand among control points of a spline.
    spline_end: str = "G5.3 ends it"  #: How a spline ends, in words.
    needs_dwell: tuple[int, ...] = (820, 860, 880, 890)  #: Canned cycles that need P.
    #: G89 feeds out to the height that G98 or G99 asks for; else to R, and goes on in rapid traverse.
    feeds_out_whole: bool = True
    #: R and the bottom stay at their heights when G90 or G91 changes; else the numbers stay, and are read anew.
    keeps_heights: bool = False
    stores_without_holes: bool = False  #: L0 stores the words of a cycle and drills no hole.
    #: Without tool-centre-point control A and C turn the table, and linear axes that the block does not name
    #: stand. Else the tip is held in any case, as where the kinematics of the machine do that.
    turns_table_alone: bool = False
    dwells_in_seconds: bool = True  #: P of a dwell; else milliseconds, unless it has a decimal point.
    keeps_words: bool = False  #: R, the bottom, Q and P hold for other cycles too, until G80.
    #: G80 ends a cycle alone: the motion code from before the cycle goes on, because cycles are a modal group of
    #: their own. Else no motion code holds after G80.
    resumes_motion: bool = False
    taps_rigidly: bool = False  #: G84 and G74 couple the spindle; else they need a floating holder.
    #: Comments that are messages, or stop the program, by their first word; those of "FILE" would open files.
    speaking_remarks: tuple[str, ...] = ("MSG", "DEBUG", "PRINT", "LOG", "ABORT", "FILE")
    starts_with_rapid: bool = False  #: G0 holds at the start.
    separates_programs: bool = False  #: An O number that is reached begins another program; else it is passed.
    tilted_plane: str = ""  #: Codes that tilt a plane and turn the tool to it.
    repeats_of_calls: str = "L"  #: Words of M98 that say how often.
