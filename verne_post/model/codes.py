"""The registry of finding codes: one row a code, with what `verne-post explain CODE` prints."""

from typing import Final

from msgspec import Struct

from verne_post.model.verdict import Severity


class Code(Struct, frozen=True):
    """What a finding code means, and what a person can do about it."""

    code: str
    title: str
    severity: Severity
    meaning: str
    remedy: str  #: Empty where each message says what would be right.


def _make_table(*rows: tuple[str, str, Severity, str, str]) -> dict[str, Code]:
    return {row[0]: Code(*row) for row in rows}


#: VP037: the other reading, where the message has the word of the language.
IF_DIRECTIONS_ARE_MEANT: Final = (
    'If directions of the machine are meant, give [fanuc] directions = "machine" for a program of a Fanuc or Haas '
    "control, or post it again with G43.4 or G68.2. If the control has another code for this, give that code the "
    'meaning "tcp on" in [remap].'
)
CODES: Final[dict[str, Code]] = _make_table(
    # --- VP0xx: text and modal state ------------------------------------------------------
    ("VP001", "unreadable block", "error",
     "The block does not consist of words of its language. A word of G-code is a letter and a number. As a "
     "warning: a line of a Klartext cycle has no ~ at its end, or a block number of RS274/NGC may be a word "
     "whose letter is missing.",
     "Correct the characters at the column of the message. In G-code, write a letter and a number; write comments "
     "in ( ) on one line, or after a ;. In Klartext, write comments after a ;."),
    ("VP002", "unknown or unsupported code", "error",
     "The word is not part of the language, or not supported by this version; it is never skipped.",
     "If the word is misspelt, correct it. If it is a code of the machine's builder, give it a meaning in [remap]. "
     "Take it out only if you know that nothing depends on it."),
    ("VP003", "two codes of one modal group", "error",
     "A block has two G or M codes of the same modal group.",
     "Keep one of them, or write two blocks."),
    ("VP004", "repeated word", "error",
     "A letter appears twice in one block. As a warning: two lines of one cycle 7 shift the same axis, and the "
     "last one is used.",
     "Keep one of them."),
    ("VP005", "missing word", "error",
     "A code needs a word that is not in its block. As a warning: a cycle of Klartext lacks its first line or its "
     "second one, such as CYCL DEF 10.0 or 10.1, BLK FORM has no 0.2, or G68.2 or CYCLE800 has no angles.",
     ""),
    ("VP006", "word without a use", "error",
     "Nothing in the block uses this word.",
     "Remove it, or add the code that it belongs to."),
    ("VP007", "number out of range", "error",
     "The number of a word is outside what the word allows. As a warning: a hole has no depth, a cycle of Klartext "
     "has the depth 0, with which the control does not run it, or DC, ACP or ACN of a Siemens program is beyond a "
     "turn.",
     ""),
    ("VP008", "impossible arc", "error",
     "Start, end and centre (or radius) of the arc do not fit together.",
     "Correct the end, the centre or the radius. Start and end must be equally far from the centre. The arc starts "
     "where the block before ends."),
    ("VP009", "feed rate missing", "error",
     "A feed move has no feed rate: F is zero, was never given, or is missing in a block under G93, where each "
     "block needs it. As a warning: a tool cuts at the feed rate of the tool before it, or a block with F moves in "
     "rapid traverse, because an earlier G0 is still active or G0 stands where G1 is meant (G0 Z-2 F300).",
     ""),
    ("VP010", "program does not end", "error",
     "The file ends without M2, M30 or a closing %. Two cases are warnings, because a control may not load such "
     "a program: (1) BEGIN PGM or END PGM of a Klartext program is missing, or they differ in name or unit. (2) "
     "A Fanuc program has a closing %, without M30 or M2 before it. Or the file is a subprogram, to which another "
     "program brings the tool: check that program.",
     ""),
    ("VP011", "axis that the machine lacks", "error",
     "The program names an axis that this machine does not have.",
     "Post the program for the rotary axes of the machine, which the message lists. Or post it with tool "
     "axes (I J K of G43.5, A3 B3 C3 of Siemens, LN of Klartext, APT), which name no rotary axis. Or give "
     "--machine a machine that has the axes of the program, such as ac_trunnion (A, C), bc_trunnion (B, C) or "
     "ab_table (A, B)."),
    ("VP012", "tool length unknown", "error",
     "The program needs a tool length that was not given.",
     "Fill in the length in INPUT.toml, which verne-post setup INPUT writes. Or give --tool-table FILE, or "
     "--tool-length MM where the program has one tool; the program may set it too (G10 L1, $TC_DP3, TOOL DEF)."),
    ("VP013", "position unknown", "error",
     "An incremental move, an arc or a G92 needs a position that no absolute word has set yet.",
     "Give the axis an absolute value first."),
    ("VP014", "stop for the operator", "error",
     "The program has M0, M6, M60, G88 or a waiting M66 after its motion has begun. A stream of setpoints cannot "
     "wait.",
     "Write one file of setpoints for each part between two stops: --split-at-stops, or "
     "split_at_stops = true in the set-up."),
    ("VP015", "machine coordinates unknown", "error",
     "A motion to a reference position needs a [home] position in the machine file, or its words do not fit "
     "the state. Such motions are G28, G30, G75, M92, a retract of CYCLE800, and GOHOME.",
     "Add [home] to the machine file, or go to machine coordinates: G53, SUPA, M91."),
    ("VP016", "tool length changed under tilt", "error",
     "After a change of the tool length offset with the table tilted, the next move must be a rapid traverse in "
     "absolute coordinates. If no length is in force any more, it names Z, or the tool is retracted before.",
     "Program a rapid traverse (G0, FMAX) to the position after the change. Before a turn of the rotary axes "
     "without a length, retract in machine coordinates (G53, G28, SUPA, M91)."),
    ("VP017", "not allowed in this modal state", "error",
     "A G code, cycle or axis word conflicts with a mode that is on (plane, compensation, tilt).",
     ""),
    ("VP018", "unusable option", "error",
     "An option and the program contradict each other. As a warning: the program and the set-up, a tool table or "
     "an option give one tool two lengths or diameters. The message names both, and says which one is used. Or no "
     "called tool is among the tool shapes.",
     ""),
    ("VP019", "unreadable tool table", "error",
     "A line of the tool table is not of the form 'T1 P1 Z50 D6 ; remark'.",
     "Write a tool in each line: its number T, pocket P, length Z, diameter D (docs/gcode.md)."),
    ("VP020", "unreadable setpoint file", "error",
     "The setpoint file does not have the columns or the numbers that the machine needs.",
     "Write the file again with verne-post convert."),
    ("VP021", "nothing to do", "error",
     "The program contains no motion. Dwells do not count, and the first position does not either: the machine "
     "starts there.",
     "Give the file that has the moves. If M30 or M2 comes before them, move it to the last line."),
    ("VP022", "program cannot be read", "error",
     "The file does not exist, may not be read, or is no program, such as a file of setpoints.",
     "Give the name of a program in a folder that you may read."),
    ("VP023", "label, loop or subprogram without its partner", "error",
     "A label, loop, branch or subroutine is not opened, closed, defined or called as it must be. As a warning: a "
     "machining cycle of Klartext is defined and not called, MCALL of a Siemens program ends nothing after a cycle "
     "that was called at one place, or the PROC line of a Siemens subprogram has another name than its call.",
     "Close blocks in reverse order, with the same label. Define a subroutine before the program calls it, "
     "or put its file beside the program or into a folder of --subroutine-path."),
    ("VP024", "endless loop or recursion, or no end before a subprogram", "error",
     "Loops and calls repeat more blocks, or are nested deeper, than is permitted. Or a program runs on into a "
     "subprogram; in Klartext, whose control executes it once more, this is a warning.",
     "Correct the condition of the loop. If so many repeats are intended, raise --max-repeats. Write M30 before the "
     "first subprogram, and M99 at the end of each."),
    ("VP025", "impossible parameter", "error",
     "The parameter does not exist, has no value, or is read-only. As a warning: a Siemens program reads an R "
     "parameter that it has not set. verne-post takes 0 for it; a control uses its last value.",
     ""),
    ("VP026", "impossible cutter compensation", "error",
     "The tool radius does not fit the contour, or compensation is not possible for this kind of move. As a "
     "warning: APPR or DEP of Klartext without RL or RR, or a D of Fanuc that no G41 or G42 uses before G40.",
     "Use a smaller tool, a longer entry move, or a contour without such corners."),
    ("VP027", "stopped by the program", "error",
     "The program stops itself, for example with (ABORT, ...).",
     "Meet the condition that the message of the program names, or give the values for which the program goes on."),
    ("VP028", "unreadable parameter file", "error",
     "A line of the parameter file is not a number and a value.",
     "Write a number and a value in each line, such as 5221 12.5, as LinuxCNC does."),
    ("VP029", "no restart (block search) at this line", "error",
     "The program does not execute the line of --from-line exactly once by itself. Or the line is inside cutter "
     "compensation, a canned cycle or the control points of a spline.",
     ""),
    ("VP030", "canned cycle words of the other distance mode", "warning",
     "A canned cycle continues after a change between G90 and G91, with an R or a depth from before the change. "
     "The number now has another meaning. Or verne-post keeps the old meaning, and another control would read "
     "the number in the new mode. The message has both depths.",
     "Give R and the bottom of the hole again after every change of G90 and G91."),
    ("VP031", "impossible spline", "error",
     "The control points, weights and knots of a spline do not make a curve that can be followed. The number of "
     "knots does not fit, knots decrease, or a weight is not positive. Or the curve does not begin at the tool, "
     "or it stops or turns back at an inner point (a cusp).",
     "Post the curve again from its source, or write straight moves or arcs where the message says."),
    ("VP032", "no program, or in another language", "error",
     "The text cannot be read. It is empty, or has words of another control or of another kind of file, or has "
     "almost no words of a program.",
     ""),
    ("VP033", "part zero not given", "warning",
     "The program uses a work offset that neither the set-up nor the program gives (in Klartext a preset). "
     "The part zero is then at the rotary centre on the table face, or at part_zero of a machine file of schema 2. "
     "In Klartext, presets 1 to 9 are G54 to G59.3 of --wcs, and presets 10 to 48 are G54.1P10 to G54.1P48. "
     'It is an error in three cases: (1) The set-up says "measure". (2) The set-up gives other work offsets and not '
     "this one. (3) The program moves it by G10 in G91.",
     "Fill in wcs.G54 in INPUT.toml, which verne-post setup INPUT writes, or give --wcs: mm from that "
     "point. If the part zero really is there, give --wcs G54=0,0,0."),
    ("VP034", "no tool length, or that of another tool", "warning",
     "The program cuts with tool length 0: no length is in force (after G49 or D0), or the tool table gives 0. "
     "Or a tool cuts with the length of the tool that was in the spindle before it. It is an error if the set-up "
     "gives the tool another length, and the tool has come down since its call. A rapid with length 0 is an "
     "error if it moves the tip of a tool of known length below the table face. It is a warning if it goes down "
     "to below Z0. Moves in machine coordinates (G53, SUPA, M91, and G28 after its via point) are not reported. "
     "If G91 is missing before G28, VP052 reports the rapid to the via point.",
     "Activate a length of the tool table (G43 H; M6 and D1; TOOL CALL; LOADTL), or give "
     "--tool-length. If the gauge line is"
     " meant, give --tool-length 0."),
    ("VP035", "motion takes too long", "error",
     "With its feed rates and dwells, the program gives more rows than --max-rows allows. The usual cause is a "
     "feed rate in another unit.",
     "Correct F or the dwell. If the program is meant to take so long, raise --max-rows."),
    ("VP036", "rotary axis not named before the first cut", "warning",
     "The program cuts before it names a rotary axis, and names it later with another angle than 0. The "
     "table is assumed to be at"
     " that angle from the start. It is an error if --from has the table at another angle.",
     "Name the rotary axes in a rapid before the first cut, at 0 if the table is to be level. If the table really is "
     "at the angle of the message, name that angle."),
    ("VP037", "tool-centre-point control not requested", "warning",
     "A program cuts while the rotary axes are turned, or while they turn, and no active code says in which "
     "directions X Y Z count. So does a rapid of a Fanuc or Haas program after G69, or after G43 in place of "
     "G43.4. In G-code they are places of the part here, as under G43.4. A control without tool-centre-point "
     "control reads them in the directions of the machine. Klartext without M128 is executed in this way, and so "
     "are Siemens programs that cut while the table is turned after TRAFOOF or CYCLE800(). An RS274/NGC program "
     "that turns a rotary axis during a cut gets no warning: LinuxCNC has no code for tool-centre-point control.",
     "Siemens: name the rotary axes before the cut, or write TRAORI if places of the part are meant. Klartext: "
     "write M128 if places of the part are meant. LinuxCNC, which does not know G43.4: change nothing if its "
     "kinematics keep the tip (--ignore VP037). Other G-code: if places of the part are meant, write G43.4 "
     "instead of G43, or post with G68.2. " + IF_DIRECTIONS_ARE_MEANT),
    ("VP038", "decimal points mixed", "warning",
     "A Fanuc program has lengths, angles or dwells with a decimal point and others without. A setting of the "
     "control "
     "decides whether a number without a point is read as written, or counts least input increments (0.001 mm).",
     'Write the points, or give the setting of the control: [fanuc] decimal_point = "calculator" or "conventional" '
     "in the settings file."),
    ("VP039", "controls differ", "note",
     "Controls differ in how they execute a word or a cycle of this program, or in what they count. The message "
     "says how verne-post executes it. Each case is reported once.",
     "Compare the message with your control. No action is needed if both agree."),
    ("VP040", "tolerance without effect", "note",
     "An option gives a tolerance of corners, but some or all corners of cuts do not use it. There the program "
     "gives its own tolerance, or stops at each corner.",
     "Leave out the option. Or remove the tolerance from the program (P of G64, CTOL, OTOL, T of cycle 32), so "
     "that the option is used."),
    ("VP041", "change of tools without T or without M6", "warning",
     "T alone only selects a tool: without M6, the previous tool stays in the spindle and cuts. M6 alone loads "
     "the tool that T has named last: without a new T, this is the same tool again. It is an error if the tool "
     "in the spindle comes down with the length of another one. It is also an error if no tool has been loaded, "
     "and a cut goes down with length 0 although the set-up gives lengths. A program that cuts before its first "
     "tool change, and changes tools later, has no first tool. A program without any tool change is for the tool "
     "in the spindle. If INPUT.toml gives a tool that no line calls, the call may be missing. T beside M6, or "
     "before the first cut after it, selects the next tool and is not reported.",
     "Write both T and M6. If the control loads the tool by another code of its builder, give that code the meaning "
     '"M6" in [remap].'),
    ("VP042", "plane without a turn of the table", "warning",
     "G68.2 says where X Y Z of a tilted plane are, and G53.1 turns the table to it. Without G53.1, or words of "
     "the rotary axes, the tool stays upright and cuts the plane at a slant. The same happens with PLANE with "
     "STAY, and with CYCLE800 with _DIR 0. A plane in which the tool is tilted anywhere is not reported. A "
     "canned cycle there is an error (VP017).",
     "Write G53.1 after G68.2, or the angles of the rotary axes. No action is needed for a ball end mill that is "
     "to cut a slanted face with an upright tool."),
    ("VP043", "plane, M128 or modal cycle not ended", "warning",
     "A tilted plane (G68.2, CYCLE800, PLANE, cycle 19) was not ended before the tool was changed, and the next "
     "tool cuts in it. Or it was not ended before G49, and an upright tool cuts in it after that. Or the program "
     "ends in it: a Heidenhain or Siemens control keeps it for the next program, a Fanuc control keeps it if a "
     "parameter says so. In Klartext, M128 was not ended before TOOL CALL, M91 or M92. Or MCALL, M89 or a canned cycle "
     "still drills after a change of tools, in another plane than that of its hole before, at the end of the program, "
     "or where Z goes up alone.",
     "End the plane before that: G69, CYCLE800(), PLANE RESET; M128: M129; MCALL: MCALL alone; M89: M99 at the last "
     "place; canned cycles: G80. No action is needed if both tools are to cut in the same plane."),
    ("VP044", "tool axis without all of its components", "warning",
     "A3=, B3= and C3= are the components of a tool axis. A Siemens control takes a missing component as 0. Two "
     "cases are reported: C3, usually the largest component, is missing; or the others do not form a vector of "
     "length 1.",
     "Write all three components."),
    ("VP045", "spindle speed unknown", "warning",
     "G96 sets a constant surface speed, as on a lathe. The control computes the spindle speed from the distance "
     "of the tool from X0. Setpoints have no spindle speed; the events have S and D.",
     "If the program is for a mill, write G97 and S, the turns a minute."),
    ("VP046", "axes move that the block does not name", "warning",
     "A block moves axes that it does not name, in one of two cases: (1) The block turns the table. No tool "
     "length is in force (before G43, after G49), or a retract in machine coordinates came before. The spindle "
     "then moves too, to keep the tip at the same point of the part. A control without tool-centre-point control "
     "does not move these axes. (2) The tool length has changed, and the next block does not name Z. With a "
     "tilted table, the tip goes to the point that was programmed before. With a level table, the tip does not "
     "move, so with a longer tool it is below that point.",
     "Name X, Y and Z in the block, or turn the table in machine coordinates (G53, SUPA, M91). In a Fanuc program "
     "(--dialect fanuc) the axes do not move while no length is in force: write G49 before the turn."),
    ("VP047", "tapping as feed moves", "note",
     "With --tapping feed a thread is a move in and a move out at pitch times speed. The axis is slower while it "
     "accelerates and brakes, and under a feed override. Therefore the spindle must follow the axis.",
     "Let the control couple the spindle to the axis. The coupling begins with the event at the beginning of the "
     "first move. It ends with the event at the end of the last."),
    ("VP048", "rigid tapping needs a choice", "error",
     "A cycle taps with the spindle coupled to the feed. Setpoints say where the axes go, not how far the spindle "
     "has turned.",
     "If the control that executes the setpoints couples the spindle to the axis, give --tapping feed, or tapping "
     "= 'feed' in the set-up. Otherwise tap with a floating holder (CYCLE840, cycle 206, G84 of RS274/NGC), or in "
     "a separate program."),
    ("VP049", "length or diameter of another tool", "warning",
     "The tool length in force is not that of the tool in the spindle: H (in CL files ADJUST) has another "
     "number, and the tool table gives the two different lengths. It is an error where the program calls the "
     "tool to which the length belongs, also by T alone, and the tool in the spindle comes down with it. An H of "
     "another number is not reported if its length is the same, or if the tool table has no length for the "
     "tool. The same rules apply to D of G41 and its diameter. It is an error if the program calls the tool of "
     "this number. A number that has only a diameter, such as D25 for T5, is not reported.",
     "Write H and D with the number of the tool. If the length belongs to the tool, as with H51 for "
     "T1, give both numbers the same length, or none to the tool's own. A number of D that is no tool has no "
     "length. If a code of the machine's builder has loaded the tool, give that code the meaning \"M6\" in [remap]."),
    ("VP050", "spindle does not turn, or turns backwards, in a cut", "warning",
     "The spindle does not turn, has no speed, or turns backwards while the tool cuts. Retracts are not "
     "reported, because they may be in the air. The same applies to moves before a start, and between a stop and a "
     "new start, that follow a retract or a rapid, unless a cycle makes them. Programs that call no tool and start "
     "no spindle are not reported, nor are oriented tools (M19, SPOS). The cases are: (1) The program moves at feed "
     "rate while the spindle does not turn. It was not started after a tool change, or it was stopped and the tool "
     "continues to cut. (2) The spindle is started without a speed: no block of the program gives S, or none since "
     "the tool change, so the spindle keeps the speed of the previous tool. (3) The spindle turns counter-clockwise "
     "(M4) in all cuts of a tool.",
     "Start the spindle before the cut (M3 and S; SPINDL in CL files). If a code of the machine's builder starts it, "
     'give that code the meaning "M3" in [remap]. No action is needed for a probe, for a tool that does not turn, or '
     "for a left-hand tool under M4."),
    ("VP051", "moves that are not executed", "warning",
     "M2, M30 or END PGM ends the program, and lines after it move axes. A control does not execute them. "
     "Subprograms and other programs that begin after this end (O, LBL, PROC, %) are not reported. "
     "Nor does a control execute the lines of a Siemens FOR that begins above its last value.",
     "If the program goes on there, delete the code that ends it. If not, delete the lines. Write the values of FOR "
     "in ascending order."),
    ("VP052", "the return to home goes down first", "warning",
     "In G28 and G30, axis words name a via point: the axes go to it first, and then home. In absolute "
     "coordinates (G90) the via point is on the part. So G90 G28 Z0 moves the tool down to the part zero in "
     "rapid traverse, and then home. It is an error if this moves the tip of a tool without a length below the "
     "table face.",
     "Write G91 G28 Z0, and G90 in the next block."),
    ("VP053", "tool length in G18 or G19", "warning",
     "A Siemens program moves X, Y or Z in the plane G18 or G19 while a tool length is in force. The setting data "
     "42940 $SC_TOOL_LENGTH_CONST of the control decides in which direction the length acts: with 17 along Z in "
     "every plane, as here; with 0, the default, along Y in G18 and along X in G19. It is reported once a program.",
     'Compare the setting data of the control. If it is 17, give [siemens] length_axis = "Z" in the settings file. '
     'If it is 0, give "plane": such motions are then refused.'),
    ("VP054", "sense of rotation contradicts a plane", "warning",
     "The program names angles of the rotary axes directly before a tilted plane, and the turn to the plane (G53.1, "
     "PLANE, CYCLE800) goes to others. The named angles would hold the same plane if one axis had the opposite "
     "sense. A post of a CAM system names the angles of its own machine. So that machine and the machine file may "
     "differ in the sense of this axis. It is reported once a program.",
     "Turn the axis on the machine by a positive angle, and compare. If the sense differs, write a_positive = "
     '"tool" in place of "workpiece" in the machine file, or the reverse (c_positive for C; positive in '
     "[joints.a] of schema 2). If it does not, the angles before the plane, or those of the plane, are wrong."),
    ("VP055", "spindle speed above the machine's", "warning",
     "S is above the greatest speed of the spindle. A control lowers it to that speed, or stops with an alarm. At a "
     "lower speed and the same feed rate, each tooth cuts more than was planned. Each speed is reported once.",
     "Write an S that the spindle reaches, and lower F in the same ratio. If the spindle reaches the speed, correct "
     "max_speed_rpm under [spindle] of the machine file."),
    ("VP056", "doubtful arc, tool axis or sign", "warning",
     "An arc of half a turn or more leaves both moves beside it at an angle, and the rest of its circle, or the "
     "arc of the same radius on the short way, would continue both. So G2 and G3 (DR- and DR+) may be exchanged, or "
     "the radius R (CR) may have the wrong sign. Or a block with R (CR) names two axes of another plane than the "
     "active one: then the tool goes along the one that is normal to the plane, on a helix. Or the tool axis of "
     "one cut is between those of two cuts before and two after it, but for the sign of one component or angle. "
     "Or four cuts before a cut and four after it go on evenly, and so would this one with another sign of one of "
     "its words, or with A and C exchanged.",
     "Correct the sense, the sign or the plane. No action is needed if it is meant, as the relief of a corner."),
    # --- VP1xx: position limits and reach --------------------------------------------------
    ("VP101", "travel of a linear axis", "error",
     "A slider, or a linear axis of a serial machine, leaves its travel (overtravel).",
     "Move the part on the table (--wcs), or use another tilt."),
    ("VP102", "tilt range", "error",
     "The axis that tilts the tool would go beyond the end of its travel. The program asks for more tilt than the "
     "machine has: A of a tilting table, or the tilting axis of a chain. If the platform tilts too, the joint a is "
     "the word A plus the tilt of the platform: A may be beyond the limit of a, and a within it.",
     "Program less tilt, or take a machine whose axis goes so far."),
    ("VP103", "rotary range", "error",
     "The axis that turns the part or the head would go beyond the end of its travel. The program has turned it too "
     "far in one direction: C, or the axis nearest the part of a chain.",
     "Retract the tool and turn the axis back in the program (rewind). Remove the limit from the machine file only "
     "if the real axis has none."),
    ("VP110", "out of reach", "error",
     "The machine cannot bring the tool to this position with this tool axis. The rods are too short, or the joints "
     "of a nutating pair do not point the tool there: the inverse kinematics has no real solution.",
     "Compare the work offset and the tool length with the machine. If both are right, move the part towards the "
     "middle of the workspace (--wcs), or use a shorter tool."),
    # --- VP2xx: singularity, rod crossing, clearance ----------------------------------------
    ("VP201", "rod crossing", "error",
     "The rods of leg I would cross in this position. The platform would have to tilt so far that one rod passes "
     "the other: every real solution has R1 cos(alpha) <= r1.",
     "Move the part towards the middle of the workspace (--wcs)."),
    ("VP202", "near a serial singularity", "warning",
     "The vertical drop of a rod, from its end at the slider to its end at the platform, comes close to zero. "
     "The rod is then nearly level, and its slider no longer moves the platform along the rod. Error below the "
     "machine file's limits.serial_singularity_mm or carrier.smallest_drop_mm, warning up to twice that. Or a "
     "great circle comes near the fold of a nutating rotary pair, where its two solutions meet. Or the tool "
     "comes near the leg of a carrier, where its wrist has a pole.",
     "At a flat rod, move the part towards the middle of the workspace (--wcs). At a fold or pole, post the program "
     "with other tool angles."),
    ("VP203", "near a parallel singularity", "warning",
     "The scaled determinant of the parallel Jacobian comes close to zero: the sliders no longer hold the platform. "
     "Error below the machine file's limits.parallel_singularity, warning up to twice that.",
     "Move the part towards the middle of the workspace (--wcs)."),
    ("VP210", "below the table face", "error",
     "The tool tip or the spindle nose is below the table face, inside the table radius.",
     "Raise the work offset (--wcs), or use a longer tool."),
    ("VP211", "rods too close", "error",
     "Two rods come closer to each other than the machine file's clearance.minimum_mm.",
     "Move the part towards the middle of the workspace (--wcs)."),
    ("VP212", "rod too close to the spindle", "error",
     "A rod comes closer to the spindle than the machine file's clearance.minimum_mm.",
     "Move the part towards the middle of the workspace (--wcs)."),
    ("VP213", "spindle or tool too close to the table", "error",
     "The spindle or the end of the largest tool comes closer to the table than the machine file's "
     "clearance.minimum_mm.",
     "Raise the work offset (--wcs), or use a longer tool."),
    ("VP214", "ball joint beyond its cone", "error",
     "A rod leaves the cone that its ball joint allows (rods.slider_cone_deg, rods.platform_cone_deg "
     "of the machine file).",
     "Move the part towards the middle of the workspace (--wcs)."),
    ("VP215", "too close to a fixture", "error",
     "Tool, spindle or platform comes closer to a keep-out box than its clearance, or reaches into it.",
     "Change the motion or the tilt, use a longer or thinner tool, or move the fixture; the message "
     "has the distance."),
    ("VP216", "in the stock", "error",
     "In rapid traverse the cutter reaches into the stock. Or shank, holder or spindle do so at any time, or the "
     "platform reaches into the box of the stock. The stock is the one that is left at that time. A warning "
     "means one of three things: the distance is smaller than the resolution of the stock model, 0.1 mm for a stock "
     "of 100 mm; the stock is not cut because the program is out of limits and long; or a tool has no diameter, so "
     "what it has cut is not known.",
     "Move the rapid traverse above the stock, retract along the tool axis, or cut the place first; use a longer or "
     "thinner tool. Where the diameter of the tool is not known, give it."),
    ("VP217", "uncorrected tool axis error", "error",
     "On the as-built machine the tool axis is off by more than accuracy.uncorrected_axis_deg of the machine file. "
     "The table's tilt cannot correct this component, and C stays as programmed.",
     "Let C correct its component (--correct-axis), or accept a larger error in the machine file."),
    ("VP218", "gouge", "error",
     "Cutter, shank or holder cut into the nominal part, along its normal deeper than --gouge, or gouge_mm of a "
     "set-up's [part]. The value is the depth by the shortest way out, which may be less than that.",
     "Compare tool, tool length and work offset with those at the machine. If they are right, change the motion at "
     "the line and place of the message."),
    ("VP219", "excess left on the part", "warning",
     "More material than --excess, or excess_mm of a set-up's [part], stays on a facet of the "
     "nominal part that the cutter came near. Or no cutter comes near any facet of it.",
     "Use a smaller stepover or a smaller cutter at the line of the message."),
    ("VP220", "gouge not decided", "error",
     "Some facets may have a gouge deeper than --gouge. The message has the depth that no gouge exceeds. "
     "It is a warning if a gouge was found elsewhere.",
     "Accept a larger --gouge (gouge_mm), or look at the places that the message and --csv of machined name."),
    ("VP221", "stock left around the part", "warning",
     "Stock is left beside or over the nominal part where no cutter has been. It reaches farther from the part than "
     "--excess or excess_mm. Causes are a ridge between strips, or a region that this set-up does not machine.",
     "Use a smaller stepover at the place in the message, or machine the stock in the next set-up."),
    # --- VP3xx: branches ------------------------------------------------------------------------
    ("VP301", "flip, rewind or large turn of the rotary axes", "error",
     "The rotary axes would have to turn far in one line. To keep a limit, the table must change to its other "
     "solution (-A, C + 180), rewind C, or leave the programmed A and C. Five cases are warnings. (1) The path "
     "begins with a vertical tool vector, at another C than a word before it names. (2) C turns under a vertical "
     "tool that does not move. (3) C turns by more than half a turn in a feed move with a tilted tool. (4) With "
     "--allow-rewind, the table changes where the tool does not feed, by a retract, a turn and a return. (5) A and "
     "C go linearly between two tool vectors on both sides of the vertical, and sweep the tool around a cone.",
     "Retract the tool where the message says, give --allow-rewind, or post the program with other angles."),
    # --- VP4xx: feed and dynamics, and what verification of a written file finds -----------------
    ("VP401", "velocity beyond its limit", "error",
     "First differences of the written setpoints exceed the velocity limit.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP402", "acceleration beyond its limit", "error",
     "Second differences of the written setpoints exceed the acceleration limit.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP403", "jerk beyond its limit", "error",
     "Third differences of the written setpoints exceed the jerk limit.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP404", "feed rate exceeded", "error",
     "The tool moves faster along the segment than the programmed feed rate.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP411", "off the programmed path", "error",
     "The pose of a row (by forward kinematics) is farther from the programmed segment than the tolerance.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP412", "setpoints incomplete", "error",
     "The file does not begin at the start pose, does not end at the last pose, or skips a segment.",
     "Do not run the file. Convert the program again, and verify the new file."),
    ("VP413", "rows out of order", "error",
     "The rows do not follow the program in its order: they run back along a line, leave a line out, or belong to "
     "a line that is not the next. The file was changed after the conversion, the program was, or verify has other "
     "options than the conversion.",
     "Do not run the file. Give verify the options of the conversion, --from and --to too. If the error stays, "
     "convert the program again, verify the new file, and copy that one to the control."),
    ("VP414", "setpoint file out of date", "error",
     "The setpoint file was made with another program, machine file, work offset, tool length or option, or the "
     "index of its parts does not say what a conversion writes.",
     "Convert the program again."),
    ("VP420", "no feasible motion profile", "error",
     "The solver found no feasible motion profile for a section; there is no verdict on the program.",
     "Try a longer control cycle (--cycle), or a simpler path at the line of the message, and report the program."),
    ("VP421", "not planned", "note",
     "check --limits-only ends after the limits of joints and the obstacles: speeds, machining time and rows are "
     "not planned.",
     "Leave out --limits-only before the program is run."),
    # --- VP5xx: machine file ----------------------------------------------------------------
    ("VP501", "unusable machine file", "error",
     "The machine file is missing, is not TOML, or a key of it is unknown, missing or out of bounds.",
     "Correct what the message names: docs/machine-file.md explains each key, and `verne-post machine show` "
     "prints a valid file."),
    ("VP502", "unreadable readings", "error",
     "A file of readings has a missing column, a value that is no number, or too little data.",
     "Correct what the message names: docs/calibration.md and docs/as-built.md show valid files."),
    ("VP503", "unusable settings file", "error",
     "The settings file is not TOML, or a key of it is unknown or has an invalid value.",
     "Correct what the message names: docs/settings.md has all keys of a settings file."),
    ("VP504", "unusable tool shapes or measured values", "error",
     "The file of tool shapes, of measured work offsets or of tool lengths cannot be read, or has an "
     "impossible value.",
     "Correct what the message names: docs/keep-out.md shows tool shapes, docs/setpoints.md measured "
     "offsets and lengths."),
    ("VP505", "implausible size", "warning",
     "A speed, feed rate, pitch of a tap, acceleration, jerk, travel, length, cycle or tolerance is possible, but "
     "probably not intended. Most often it is in another unit. It is in the machine file, the command line, the "
     "set-up or the program. Or four cuts before a cut and four after it go on evenly, and so would this one with ten "
     "times or a tenth of one of its words. Or a rapid goes down below every cut of its tool, mostly to a height with "
     "the wrong sign. Or a tool cuts nothing of the stock that another tool cuts in the same work system. Or no cut "
     "at all comes into the stock, which may stand elsewhere: its numbers are read from the table "
     "unless it has a system. Or the nominal part reaches outside the stock, or all fixtures together are shorter than "
     "10 mm, or a mesh is much larger than the table, or cuts go past the stock or the part, and would be in it in a "
     "larger unit: their unit may be another one. Or the set-up was written for "
     "another machine, where places and lengths may count from other points. Or the tool of a machine file points up "
     "wherever its joints are. The pitch of a tap is in doubt where it exceeds the diameter of the tool or 8 mm, is "
     "below 0.15 mm, or is not that of the thread in the remark of the tool. M8X1 there allows 0.85 to 1.15 times 1 "
     "mm, and M8 alone 0.25 to 1.15 times its coarse pitch, 1.25 mm. "
     "It is an error where a program cuts with 200 mm a turn (G95) or more, where it exceeds the travel in "
     "inches but not in mm, and where it touches a mesh that fits on the table only in mm. Then the limits that "
     "the program breaks, or contacts with the mesh, are not listed. `verne-post explain` names limits of a line.",
     "Compare a value of a file with its unit in docs/machine-file.md, docs/settings.md or docs/setpoints.md; "
     "`verne-post machine validate` prints how long moves take. Correct a value of the program there. For a set-up of "
     "another machine, give --machine NAME, or measure places and lengths anew. No action is needed if the value is "
     "meant."),
    ("VP506", "unusable mesh", "error",
     "A mesh is no STL file, or has an implausible size for its unit. Or it is not the surface of a body: it is "
     "open, flipped or inside out.",
     "Export the body again as a closed STL, and give its unit. The message says what is wrong."),
    ("VP507", "unreadable configuration of another control", "error",
     "A line, a number, a unit or a limit cannot be read, or is missing. It belongs to a file given to `machine "
     "import`, or to one that this file names.",
     "Correct what the message names: docs/machines.md says what is read."),
    ("VP508", "kinematics that are not imported", "error",
     "No kind of machine here has the kinematics of the configuration, or the formulas were not compared.",
     "Start from the machine file that the message or the table in docs/machines.md names."),
    ("VP509", "not imported", "warning",
     "The imported machine file leaves out something of the configuration, or has a default for a value that the "
     "configuration does not set.",
     "Check each of these in the new file before the machine moves."),
    # --- VP9xx: internal ----------------------------------------------------------------------
    ("VP901", "converted file failed verification", "error",
     "The setpoints that were to be written did not pass verification. Nothing was written.",
     "This is a bug: report it with the program and the machine file."),
    ("VP902", "internal error", "error",
     "The conversion has failed with an unexpected error, or its process was killed.",
     "Convert this program alone with VERNE_POST_TRACEBACK=1, and report it."),
)  # fmt: skip

#: Numbers of codes that are errors in some cases and warnings in others.
_EITHER: Final = (1, 4, 5, 7, 9, 10, 18, 23, 24, 25, 26, 33, 34, 36, 41, 49, 52, 202, 203, 216, 301, 505)


def describe_severity(code: Code) -> str:
    """The severity, or both where a code has either."""
    return "warning or error" if int(code.code[2:]) in _EITHER else code.severity


def describe_response(code: Code) -> str:
    """What the program does about a finding of this code: exit status, and whether anything is written."""
    number = int(code.code[2:])
    if code.severity == "note":
        return "For information only; exit status and setpoints are not changed."
    warned = "it is printed and does not stop the conversion; check --fail-level warning then ends with 1."
    if code.code == "VP509":
        return "It is printed, and the machine file is written all the same."
    if code.severity == "warning" and number not in _EITHER:
        return warned[0].upper() + warned[1:]
    if number < 100:
        text = "Nothing is written, exit status 2."
        if number in _EITHER:
            return f"As an error: {text[0].lower()}{text[1:]} As a warning: {warned}"
        return f"{text} Reading goes on to the next mistakes, 50 at most."
    if code.code == "VP220":
        return "There is no verdict: exit status 3, and 1 where something else is gouged; convert writes nothing."
    if number < 400 or code.code == "VP505":
        text = "convert writes nothing; check and convert end with status 1 (check --exit-zero: 0)."
        if number in _EITHER:
            text = f"As an error: {text} As a warning: {warned}"
        return text
    if code.code == "VP420":
        return "There is no verdict: nothing is written, exit status 3."
    if code.code == "VP414":
        return "verify ends with status 1."
    if number < 500:
        return (
            "verify ends with status 1. convert checks its rows in the same way before anything is written; "
            "there it is VP901."
        )
    return "Nothing is read or written, exit status 2." if number < 900 else "Nothing is written, exit status 70."
