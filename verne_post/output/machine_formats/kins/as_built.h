/* The whole machine as built: six rods, three guides, two table axes and a spindle where they really are.
 *
 * Rod i of leg j holds the platform at P with the rotation R:  |P + R a_i - b_i - rho_j u_j| = L_i. The tip is exact; the
 * table's tilt takes the component of the tool axis that it can, C stays as programmed. Newton's method, its unknowns
 * a turn of the platform (inverse: both rods of a leg must ask for one slider position; the rest is explicit) or
 * the platform's pose (forward). It starts at the closed form of the ideal machine, which is carrier.h. With NEWTON it
 * starts from the solution before, or upright, and from the closed form where that leads nowhere.
 *
 * Upright frame: F base seen from the pivot, F = diag(1, -1, -1).
 */
#include <string.h>

/* The platform, and what each rod asks of its slider there. */
struct placed {
    double spindle[3], cosine, sine, stretch; /* R s; the table's further turn, and what its derivative is divided by */
    double p[3], arm[6][3], rod[6][3], drop[6], rho[6];
};

/* Tip and tool axis with the table at its programmed angles, split about the tilt axis: a further turn by t makes of them
 * part 0 + part 1 cos t + part 2 sin t. length: from P to the tip. */
struct programmed {
    double tip[3][3], axis[3][3], length;
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void mirror(double v[3])
{
    v[1] = -v[1];
    v[2] = -v[2];
}

/* What a turn about a unit axis keeps of a vector, multiplies by its cosine, and by its sine. */
static void split_about(const double axis[3], const double v[3], double part[3][3])
{
    double along = dot(axis, v);
    int k;
    for (k = 0; k < 3; k++) {
        part[0][k] = axis[k] * along;
        part[1][k] = v[k] - part[0][k];
    }
    cross(axis, v, part[2]);
}

static void join(double part[3][3], double c, double s, double out[3])
{
    int k;
    for (k = 0; k < 3; k++)
        out[k] = part[0][k] + part[1][k] * c + part[2][k] * s;
}

static void turn_about(const double axis[3], double v[3], double c, double s)
{
    double part[3][3];
    split_about(axis, v, part);
    join(part, c, s, v);
}

static void rotate(double r[3][3], const double v[3], double out[3])
{
    int k;
    for (k = 0; k < 3; k++)
        out[k] = dot(r[k], v);
}

/* A rotation followed by a small turn, exactly orthogonal (Cayley), equal to it up to third order. */
static void turn_rotation(double r[3][3], const double turn[3])
{
    const double half[3] = {0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]};
    const double scale = 2.0 / (1.0 + dot(half, half));
    double once[3], twice[3];
    int j, k;
    for (j = 0; j < 3; j++) {
        const double column[3] = {r[0][j], r[1][j], r[2][j]};
        cross(half, column, once);
        cross(half, once, twice);
        for (k = 0; k < 3; k++)
            r[k][j] += scale * (once[k] + twice[k]);
    }
}

static struct programmed stand_on_table(const struct pose *world, double tool_length)
{
    struct programmed made;
    const double a = world->a / a_factor, c = world->c / c_factor, ca = cos(a), sa = sin(a), cc = cos(c), sc = sin(c);
    double tip[3] = {world->x + machine_zero[0], world->y + machine_zero[1], world->z + machine_zero[2] - tool_length};
    double axis[3] = {sc * sa, cc * sa, ca};
    int k;
    turn_about(rotary_axis, axis, cc, sc);
    turn_about(rotary_axis, tip, cc, sc);
    for (k = 0; k < 3; k++)
        tip[k] += rotary_origin[k] - tilt_origin[k];
    turn_about(tilt_axis, axis, ca, sa);
    turn_about(tilt_axis, tip, ca, sa);
    split_about(tilt_axis, axis, made.axis);
    split_about(tilt_axis, tip, made.tip);
    made.length = tool_length + nose_offset;
    return made;
}

/* Everything that follows from the platform's rotation; -1 where a rod does not reach its guide. */
static int place(struct programmed *pose, double r[3][3], struct placed *at)
{
    double upright[3], x, y, height, square;
    int i, k;
    rotate(r, spindle, at->spindle);
    upright[0] = -at->spindle[0], upright[1] = at->spindle[1], upright[2] = at->spindle[2];
    x = dot(upright, pose->axis[1]);
    y = dot(upright, pose->axis[2]);
    at->stretch = sqrt(x * x + y * y);
    at->cosine = x / at->stretch;
    at->sine = y / at->stretch;
    join(pose->tip, at->cosine, at->sine, at->p);
    for (k = 0; k < 3; k++)
        at->p[k] += tilt_origin[k];
    mirror(at->p);
    for (k = 0; k < 3; k++)
        at->p[k] += pivot[k] - pose->length * at->spindle[k];
    for (i = 0; i < 6; i++) {
        const double *guide = guides + 3 * i;
        double *rod = at->rod[i];
        rotate(r, platform_ends + 3 * i, at->arm[i]);
        for (k = 0; k < 3; k++)
            rod[k] = at->p[k] + at->arm[i][k] - slider_ends[3 * i + k];
        height = dot(guide, rod);
        square = height * height - dot(rod, rod) + rods[i] * rods[i];
        if (!(square > 0.0))
            return -1;
        at->drop[i] = sqrt(square);
        at->rho[i] = height - at->drop[i];
        for (k = 0; k < 3; k++)
            rod[k] -= at->rho[i] * guide[k];
    }
    return 0;
}

/* Newton's step, a turn of the platform: how much the rods of a leg differ in rho, over how that changes with the turn. */
static int find_turn(struct programmed *pose, struct placed *at, double turn[3])
{
    double axis_rate[3], tip_rate[3], table[3], rate[6][3], rows[3][3];
    int i, k;
    for (k = 0; k < 3; k++) {
        axis_rate[k] = pose->axis[2][k] * at->cosine - pose->axis[1][k] * at->sine;
        tip_rate[k] = pose->tip[2][k] * at->cosine - pose->tip[1][k] * at->sine;
    }
    mirror(axis_rate);
    mirror(tip_rate);
    cross(at->spindle, axis_rate, table); /* minus the turn of the table by a turn of the platform, times stretch */
    for (i = 0; i < 6; i++) {
        double lever[3], by_table = dot(at->rod[i], tip_rate) / at->stretch;
        for (k = 0; k < 3; k++)
            lever[k] = at->arm[i][k] - pose->length * at->spindle[k];
        cross(lever, at->rod[i], rate[i]);
        for (k = 0; k < 3; k++)
            rate[i][k] = (rate[i][k] - table[k] * by_table) / at->drop[i];
    }
    for (i = 0; i < 3; i++) {
        turn[i] = at->rho[2 * i + 1] - at->rho[2 * i];
        for (k = 0; k < 3; k++)
            rows[i][k] = rate[2 * i][k] - rate[2 * i + 1][k];
    }
    return solve_linear(3, rows, turn);
}

/* Rods of leg I uncrossed, and no leg dropping less than `least_drop`, mm, along its guide. */
static int is_built_working(double arm[6][3], const double drop[6], double least_drop)
{
    int k;
    for (k = 0; k < 6; k += 2)
        if (!(0.5 * (drop[k] + drop[k + 1]) > least_drop))
            return 0;
    return arm[0][1] - arm[1][1] > slider_ends[1] - slider_ends[4];
}

/* Newton from the rotation in m; written: rho, p, rotation. */
static int built_inverse(struct programmed *pose, struct memory *m, double *further)
{
    struct placed at;
    double turn[3];
    int step, k, last = 0;
    for (step = 0; step < NEWTON_STEPS; step++) {
        if (place(pose, m->rotation, &at))
            return -1;
        if (last)
            break;
        if (find_turn(pose, &at, turn) || !(dot(turn, turn) < 1.0))
            return -1;
        turn_rotation(m->rotation, turn);
        last = dot(turn, turn) < SMALL_STEP * SMALL_STEP;
    }
    if (!last || !is_built_working(at.arm, at.drop, serial_singularity_mm))
        return -1;
    for (k = 0; k < 3; k++) {
        if (!(fabs(at.rho[2 * k] - at.rho[2 * k + 1]) * CARRIER_SIZE < CLOSED_MM2))
            return -1;
        m->rho[k] = 0.5 * (at.rho[2 * k] + at.rho[2 * k + 1]);
        m->p[k] = at.p[k];
    }
    *further = atan2(at.sine, at.cosine);
    return 0;
}

/* Newton on the six rods from p and rotation in m. */
static int built_forward(const double rho[3], struct memory *m)
{
    double rows[6][6], move[6], arm[6][3], rod[6][3], drop[6], size;
    int step, i, k, last = 0;
    for (step = 0; step < NEWTON_STEPS; step++) {
        double worst = 0.0;
        for (i = 0; i < 6; i++) {
            rotate(m->rotation, platform_ends + 3 * i, arm[i]);
            for (k = 0; k < 3; k++)
                rod[i][k] = m->p[k] + arm[i][k] - slider_ends[3 * i + k] - rho[i / 2] * guides[3 * i + k];
            drop[i] = dot(guides + 3 * i, rod[i]);
            move[i] = 0.5 * (rods[i] * rods[i] - dot(rod[i], rod[i]));
            worst = fmax(worst, fabs(2.0 * move[i]));
            for (k = 0; k < 3; k++)
                rows[i][k] = rod[i][k];
            cross(arm[i], rod[i], rows[i] + 3);
        }
        if (last) {
            memcpy(m->rho, rho, sizeof(m->rho));
            return worst < CLOSED_MM2 && is_built_working(arm, drop, 0.0) ? 0 : -1;
        }
        if (solve_linear(6, rows, move))
            return -1;
        for (k = 0; k < 3; k++)
            m->p[k] += move[k];
        turn_rotation(m->rotation, move + 3);
        size = sqrt(dot(move, move)) / CARRIER_SIZE + sqrt(dot(move + 3, move + 3));
        if (!(size < 1.0))
            return -1;
        last = size < SMALL_STEP;
    }
    return -1;
}

static void tilt_platform(struct memory *m, double alpha)
{
    const double c = cos(alpha), s = sin(alpha), tilted[3][3] = {{1.0, 0.0, 0.0}, {0.0, c, -s}, {0.0, s, c}};
    memcpy(m->rotation, tilted, sizeof(tilted));
}

/* Joints of a world pose.
 *
 * joint: sliders in mm, A and C in degrees. memory: written; read only with NEWTON.
 * Returns 0, or -1 where the machine cannot stand there: then joint and memory are as before.
 */
static int model_inverse(const struct pose *world, double tool_length, enum solver solver, struct memory *memory, double joint[5])
{
    struct programmed pose;
    struct gauge g;
    struct memory m = *memory;
    double further = 0.0;
    int solved = 0;
    if (!isfinite(world->x + world->y + world->z + world->a + world->c + tool_length))
        return -1;
    pose = stand_on_table(world, tool_length);
    if (solver == NEWTON) {
        if (!m.known)
            tilt_platform(&m, 0.0);
        solved = !built_inverse(&pose, &m, &further);
    }
    if (!solved) {
        g = gauge_of(world, tool_length);
        if (carrier_inverse(g.point, &m))
            return -1;
        tilt_platform(&m, m.alpha);
        if (built_inverse(&pose, &m, &further))
            return -1;
    }
    m.known = 1;
    *memory = m;
    memcpy(joint, m.rho, sizeof(m.rho));
    joint[3] = world->a + a_factor * further;
    joint[4] = world->c;
    return 0;
}

/* World pose of joints; arguments and result as model_inverse. */
static int model_forward(const double joint[5], double tool_length, enum solver solver, struct memory *memory, struct pose *world)
{
    struct memory m = *memory;
    const double a = joint[3] / a_factor, c = joint[4] / c_factor, ca = cos(a), sa = sin(a), cc = cos(c), sc = sin(c);
    double tip[3], axis[3], level[3] = {sc, cc, 0.0}, up[3] = {0.0, 0.0, 1.0}, normal[3], programmed;
    int k, solved = 0;
    if (!isfinite(joint[0] + joint[1] + joint[2] + joint[3] + joint[4] + tool_length))
        return -1;
    if (solver == NEWTON) {
        if (!m.known) {
            tilt_platform(&m, 0.0);
            carrier_guess_point(joint, m.p);
        }
        solved = !built_forward(joint, &m);
    }
    if (!solved) {
        if (carrier_forward(joint, &m))
            return -1;
        tilt_platform(&m, m.alpha);
        if (built_forward(joint, &m))
            return -1;
    }
    m.known = 1;
    *memory = m;
    rotate(m.rotation, spindle, axis);
    for (k = 0; k < 3; k++) {
        tip[k] = m.p[k] + (tool_length + nose_offset) * axis[k] - pivot[k];
        axis[k] = -axis[k];
    }
    mirror(tip);
    mirror(axis);
    for (k = 0; k < 3; k++)
        tip[k] -= tilt_origin[k];
    turn_about(tilt_axis, tip, ca, -sa);
    turn_about(tilt_axis, axis, ca, -sa);
    for (k = 0; k < 3; k++)
        tip[k] += tilt_origin[k] - rotary_origin[k];
    turn_about(rotary_axis, tip, cc, -sc);
    /* The programmed axis combines `level` and `up`, and lies in one plane with the true axis and the tilt axis. */
    turn_about(rotary_axis, level, cc, sc);
    turn_about(rotary_axis, up, cc, sc);
    cross(tilt_axis, up, normal);
    programmed = -dot(axis, normal);
    cross(tilt_axis, level, normal);
    programmed = atan2(programmed, dot(axis, normal));
    programmed += 2.0 * M_PI * rint((a - programmed) / (2.0 * M_PI));
    world->x = tip[0] - machine_zero[0];
    world->y = tip[1] - machine_zero[1];
    world->z = tip[2] - machine_zero[2] + tool_length;
    world->a = a_factor * programmed;
    world->c = joint[4];
    return 0;
}

/* Steps of the Jacobian's central differences: mm, and degrees. Their error is about 1e-8. */
#define DIFFERENCE_MM 1e-3
#define DIFFERENCE_DEG 6e-5

/* Jacobian of the actuators at a solved pose: d(joints) = rates d(x, y, z, a, c), joints and pose in mm and degrees. */
static int model_jacobian(const struct pose *world, double tool_length, const struct memory *at, double rates[5][5])
{
    int i, j, side;
    for (j = 0; j < 5; j++) {
        double joint[2][5], step = j < 3 ? DIFFERENCE_MM : DIFFERENCE_DEG;
        for (side = 0; side < 2; side++) {
            struct memory m = *at;
            double asked[5] = {world->x, world->y, world->z, world->a, world->c};
            struct pose beside;
            asked[j] += side ? step : -step;
            beside.x = asked[0], beside.y = asked[1], beside.z = asked[2], beside.a = asked[3], beside.c = asked[4];
            if (model_inverse(&beside, tool_length, NEWTON, &m, joint[side]))
                return -1;
        }
        for (i = 0; i < 5; i++)
            rates[i][j] = (joint[1][i] - joint[0][i]) / (2.0 * step);
    }
    return 0;
}
