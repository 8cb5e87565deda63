"""Every epsilon of the project: its name, its value and the reason for it.

A number that decides between "equal" and "different" stands here or nowhere.
Lengths in mm, angles in rad, times in s, unless the name says otherwise.
"""

from typing import Final

# --- places on the table, and tools --------------------------------------------------------

#: A work offset of the program that differs from the given one by less is the same, mm: noise of two sums.
OFFSET_NOISE: Final = 1e-9

#: A cutter may be thinner or thicker than the tool table says by this, mm: wear, and sizes as measured.
DIAMETER_SLACK_MM: Final = 0.2

# --- what counts as no motion ------------------------------------------------------------

#: A move shorter than this is no move. Programs carry 3 to 6 decimals; a nanometre is far below
#: any of them and far above the rounding of a coordinate transformation (1e-13).
ZERO_LENGTH_MM: Final = 1e-6
#: The same for rotary words: 1e-7 deg, a tenth of the finest decimals seen in posted programs.
ZERO_ANGLE: Final = 2e-9

# --- kinematics --------------------------------------------------------------------------

#: Newton on the platform's pose stops when the step is below this (rad, and this share of a rod's length); the next one
#: would be below the spacing of doubles, because the iteration is quadratic.
NEWTON_STEP: Final = 1e-9
#: The iteration for the sine of the platform's tilt stops when its step is below this. It is cubic: in the middle of
#: the workspace the next step would be 0.3 times this cubed, below the spacing of doubles.
TILT_STEP: Final = 5e-6
#: Near leg I's serial singularity the equation bends more. The size of the next step, the step times the square of its
#: relative correction by the second derivative, has to be below this too.
TILT_ERROR: Final = 1e-17
#: Newton on the platform's rotation stops when the next step (rad) would be below this: sliders then stand to 1e-14 mm.
PLATFORM_ERROR: Final = 1e-17
#: The least bend of the equations of that rotation (half the second derivative over the first, 1/rad). It is assumed
#: where a step is too small to tell. It is 0.1 to 1.0 over the workspace, with tools up to 300 mm and deviations of 1
#: mm.
PLATFORM_BEND: Final = 10.0
#: C of a corrected tool axis, and nominal angles of written joints, settle below this step, rad: 1e-10 mm per metre.
CORRECTION_STEP: Final = 1e-13
#: Steps of central differences of the as-built joints: mm, and a thousandth of it in rad. Rounding (1e-12 mm) and the
#: third derivative both leave about 1e-8.
DIFFERENCE_STEP: Final = 1e-3
#: Bisection of the tilt ends here: 2**-53 of the bracket, there is nothing left to gain.
BRACKET_STEPS: Final = 60
#: A root of the squared equation counts as real below this imaginary part; a double root splits
#: into a pair of about sqrt(machine epsilon) = 1.5e-8.
REAL_ROOT_IMAG: Final = 1e-6
#: Residual of the rod equations (mm2) that a polished solution must reach; 1e-9 mm on a rod of 950.
ROD_RESIDUAL_MM2: Final = 2e-6
#: sin(tilt of the tool axis) below which the axis counts as vertical, so that C means nothing.
POLE_SINE: Final = 1e-9

# --- drives --------------------------------------------------------------------------------

#: The iteration for a commanded place ends below this step (mm, degrees): rounding of a coordinate of some hundred mm.
DRIVE_STEP: Final = 1e-13

# --- identification of lengths from measured poses -----------------------------------------

#: Corrections of readings have settled below this step (mm, rad): far below any instrument, above rounding.
ADJUST_STEP: Final = 1e-11
#: Singular value over the largest one that counts as none: a few roundings of derivatives that differ by 1e3.
RANK_SHARE: Final = 1e-9
#: A combination of lengths is not determined when its standard uncertainty exceeds this share of the longest one:
#: linearised uncertainties mean nothing there, and no machine file could use the value.
WEAK_SHARE: Final = 0.01
#: ... or when its leverage is less than this many times what errors of the readings alone would give.
NOISE_LEVERAGE: Final = 3.0
#: Coefficients below this are left out where an undetermined combination is named.
SMALL_COEFFICIENT: Final = 0.03
#: No coordinate of a machine is larger, mm; a larger number is a typing mistake, and would dominate the fit.
LARGEST_READING_MM: Final = 1e6
#: Two fits that end closer than this in every length ended in one place.
SAME_LENGTHS_MM: Final = 0.01

# --- limits ------------------------------------------------------------------------------

#: A value counts as beyond a limit when it exceeds it by more than this. One nanometre: above the
#: noise of the evaluation, a ten-thousandth of the smallest excess that a machine could notice.
LIMIT_SLACK_MM: Final = 1e-6
#: The same for angles (6e-8 deg).
LIMIT_SLACK: Final = 1e-9

# --- spans: how well a polynomial must stand for the exact joint coordinate -------------------

#: Largest accepted size of the last Chebyshev coefficients of a joint coordinate over one span.
#: It enters the bounds between samples, and is a tenth of LIMIT_SLACK_MM.
SPAN_TAIL_MM: Final = 1e-7
#: The same for angles.
SPAN_TAIL: Final = 1e-10

#: A great circle of tool axes that passes the pole nearer than this (rad) goes through it: C then stays, and the axis
#: leaves the circle by no more than that, half of what verification accepts. Around the pole C would spin half a turn.
#: A programmed axis that is this near is vertical: six decimals of I and J leave 7e-7.
POLE_CROSSING: Final = 1e-5
#: Two tool axes this near to opposite (rad) leave the great circle between them open.
OPPOSITE: Final = 1e-6

# --- tool path ---------------------------------------------------------------------------

#: Two segments continue each other without a stop when direction, curvature and rotary rate per
#: length differ by less than this (relative, curvature times 1 mm). At 833 mm/s a kink of
#: 1e-8 is a step of 8e-6 mm/s, which a 1 ms file shows as 8 mm/s3: a ten-thousandth of the jerk limit.
CONTINUATION: Final = 1e-8

#: Programmed poses are kept to so many decimals: far below any program's own, above the noise of turning and shifting.
#: Two texts that say the same place in other words then have the same setpoints.
POSE_DECIMALS_MM: Final = 9
POSE_DECIMALS_RAD: Final = 12

#: Control points no farther than this from a straight line (mm, degrees) are on it: the last of POSE_DECIMALS_MM.
STRAIGHT_MM: Final = 1e-9
#: The parameter of a spline by arc length is exact to this share of a part of it. A point stays on the curve, and is
#: off along it by less than POSE_DECIMALS_MM on a part of a metre. The share is a few roundings of a polynomial with 16
#: coefficients.
EVEN_PARAMETER: Final = 2e-13

# --- G-code (values measured on LinuxCNC's interpreter) -----------------------------------

#: Numbers that must be whole (M, T, P, H, ...) may be off by this much.
WHOLE_NUMBER: Final = 1e-4
#: A canned cycle drills where the tool points: 1 - cosine of the angle between both (0.08 degrees; two decimals).
DRILL_TILT: Final = 1e-6
#: Without tool-centre-point control the tip follows a curve on the workpiece while the table turns. The curve counts as
#: straight where it is this near to a line (mm): half the tolerance at corners.
ROTARY_CHORD_MM: Final = 0.005
#: Linear axes of the machine that a block does not name may move so far without a warning (mm). A turn of the table
#: about an axis that the spindle stands over moves them by rounded offsets; a person would stop a larger motion.
UNNAMED_MOTION_MM: Final = 0.1
#: A table that stands closer to A 0 and C 0 than this (deg) is not turned: half the last of four decimals.
UPRIGHT_DEG: Final = 5e-5
#: Cutter compensation: directions that differ by less than this (rad) continue each other without a corner.
CORNER_ANGLE: Final = 1e-7
#: ... and an offset segment may end this far (mm) before it begins: noise of the program's last decimal.
CORNER_REACH_MM: Final = 1e-6
#: EQ and NE take numbers that are closer for equal (LinuxCNC's own value since 2.9).
EQUAL_NUMBERS: Final = 1e-6
#: The length of a programmed tool axis may differ from 1 by this: three decimals, twice rounded.
VECTOR_LENGTH: Final = 2e-3
#: Radius mismatch of an arc that is always accepted ...
ARC_RADIUS_MM: Final = 0.02828427
#: The same in a block read in inches (0.002828427 in).
ARC_RADIUS_INCH_MM: Final = 0.07184205
#: ... and the share of the radius that is accepted up to a hundred times that.
ARC_RADIUS_SHARE: Final = 1e-3
#: End and start of an arc that are nearer than this are one place: half the last of six decimals. Programs carry no
#: finer ones, and sums, polar words and offsets leave far less (1e-9).
ARC_CHORD_MM: Final = 5e-7
#: An R word may be too small by this much; the arc is then a half circle.
ARC_R_TOO_SMALL_MM: Final = 0.00127
#: A chord that is shorter than twice R by no more than this share makes a half circle about its middle.
ARC_HALF_CIRCLE_SHARE: Final = 1e-12
#: The start pose is found by replaying the opening lines; it must reproduce itself this well.
START_POSE_MM: Final = 1e-7

# --- acceptance of a written file (docs/verification.md) ---------------------------------------

VELOCITY_RATIO: Final = 1.001
ACCELERATION_RATIO: Final = 1.005
JERK_RATIO: Final = 1.02
FEED_RATIO: Final = 1.001
#: Tip and axis against the programmed segment, where no blend is allowed.
PATH_TIP_MM: Final = 1e-3
PATH_AXIS_DEG: Final = 1e-3
#: Share of a column's limits that rounding to its decimals may cost: half of what is accepted beyond the limit, or less
#: where repairs of the profile have used some of it (velocity, acceleration, jerk).
ROUNDING_SHARES: Final = (2e-4, 1e-3, 0.01)
#: Noise that exceeds its share by no more than this, relative, is inside it: decimals are chosen for equality.
SHARE_ROUNDING: Final = 1e-12
#: A duration this close above a whole number of cycles, or of knots, is that number: in cycles, and as a share.
WHOLE_CYCLE: Final = 1e-9
WHOLE_CYCLE_SHARE: Final = 1e-12
#: A joint that moves less than this over a file (mm, rad) stands still: its errors are not divided by its motion.
STANDING_JOINT: Final = 1e-9
#: A unit of the last decimal is no larger than this, mm and rad. The tip moves by three times the one and a metre times
#: the other, together 5 % of PATH_TIP_MM.
ROUNDING_MM: Final = 1e-5
ROUNDING_RAD: Final = 2e-8

# --- toolpath ----------------------------------------------------------------------------------

#: A segment of which curves leave no more than this share has no element of its own: only their rounding is left.
USED_UP_SHARE: Final = 1e-9
#: Stands for the reach of a corner that is not blended, mm: its blend is too small to change a coordinate.
NO_REACH_MM: Final = 1e-100
#: Rotary travel counts in steps of this, rad: so equal sums are equal, and the first branch, as programmed, is kept.
TRAVEL_STEP: Final = 1e-6
#: Ends of a segment that follow the part to within this, mm and rad, are tied to it.
TIED: Final = 1e-6
#: A margin that changes by less than this over all places of the part does not depend on the place.
MARGIN_CHANGE: Final = 1e-6
#: A margin must change by this with C to count, and to be worth a turn of the part.
MARGIN_GAIN: Final = 1e-9
