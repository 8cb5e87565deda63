/* The whole machine with ideal parts: the platform tilts about x alone, the axes of the table cross. */

/* P = pivot + F Rx(alpha) g, and its derivative by alpha. */
static void point_of_tilt(const double g[3], double c, double s, double p[3], double by_alpha[3])
{
    p[0] = pivot[0] + g[0];
    p[1] = pivot[1] - (c * g[1] - s * g[2]);
    p[2] = pivot[2] - (s * g[1] + c * g[2]);
    by_alpha[0] = 0.0;
    by_alpha[1] = s * g[1] + c * g[2];
    by_alpha[2] = -(c * g[1] - s * g[2]);
}

/* Newton on the closure equations of the carrier for the sliders and alpha, P a function of alpha. */
static int newton_inverse(const double g[3], struct memory *m)
{
    double p[3], by_alpha[3], alpha = 0.0, rho[3], value[4], parallel[4][4], serial[4][3], a[4][4];
    int step, i, k;
    if (m->known) {
        alpha = m->alpha;
        for (k = 0; k < 3; k++)
            rho[k] = m->rho[k];
    } else {
        point_of_tilt(g, 1.0, 0.0, p, by_alpha);
        carrier_guess_sliders(p, rho);
    }
    for (step = 0; step < NEWTON_STEPS; step++) {
        double c = cos(alpha), s = sin(alpha), size;
        point_of_tilt(g, c, s, p, by_alpha);
        carrier_closure(p, c, s, rho, value, parallel, serial);
        for (i = 0; i < 4; i++) {
            a[i][3] = parallel[i][3];
            for (k = 0; k < 3; k++) {
                a[i][k] = serial[i][k];
                a[i][3] += parallel[i][k] * by_alpha[k];
            }
        }
        if (solve_linear(4, a, value))
            return -1;
        size = take_step(value, rho, &alpha);
        if (size < SMALL_STEP) {
            point_of_tilt(g, cos(alpha), sin(alpha), p, by_alpha);
            m->alpha = alpha;
            for (k = 0; k < 3; k++) {
                m->rho[k] = rho[k];
                m->p[k] = p[k];
            }
            return 0;
        }
        if (!(size < 1e6))
            return -1;
    }
    return -1;
}

/* Joints of a world pose.
 *
 * joint: sliders in mm, A and C in degrees. memory: written; read only by Newton's method.
 * Returns 0, or -1 where the machine cannot stand there: then joint and memory are as before.
 */
static int model_inverse(const struct pose *world, double tool_length, enum solver solver, struct memory *memory, double joint[5])
{
    struct gauge g;
    struct memory m = *memory;
    int k, solved, warm;
    if (!isfinite(world->x + world->y + world->z + world->a + world->c + tool_length))
        return -1;
    g = gauge_of(world, tool_length);
    if (solver != NEWTON)
        solved = !carrier_inverse(g.point, &m) && is_working(&m, serial_singularity_mm);
    else
        do { /* from the last solution; where that leads nowhere, once more from the middle of the workspace */
            warm = m.known;
            solved = !newton_inverse(g.point, &m) && is_working(&m, serial_singularity_mm);
            m.known = 0;
        } while (!solved && warm);
    if (!solved)
        return -1;
    m.known = 1;
    *memory = m;
    for (k = 0; k < 3; k++)
        joint[k] = m.rho[k];
    joint[3] = world->a + a_factor * m.alpha;
    joint[4] = world->c;
    return 0;
}

/* World pose of joints; arguments and result as model_inverse. */
static int model_forward(const double joint[5], double tool_length, enum solver solver, struct memory *memory, struct pose *world)
{
    struct memory m = *memory;
    double c, s, u[3], v[3], ca, sa, cc, sc, a;
    int solved, warm;
    if (!isfinite(joint[0] + joint[1] + joint[2] + joint[3] + joint[4] + tool_length))
        return -1;
    if (solver != NEWTON)
        solved = !carrier_forward(joint, &m) && is_working(&m, 0.0);
    else
        do { /* as in model_inverse */
            warm = m.known;
            solved = !newton_forward(joint, &m) && is_working(&m, 0.0);
            m.known = 0;
        } while (!solved && warm);
    if (!solved)
        return -1;
    m.known = 1;
    *memory = m;
    c = cos(m.alpha);
    s = sin(m.alpha);
    /* g = Rx(-alpha) F (P - pivot), then back through the table */
    u[0] = m.p[0] - pivot[0];
    u[1] = -(m.p[1] - pivot[1]);
    u[2] = -(m.p[2] - pivot[2]);
    v[1] = c * u[1] + s * u[2];
    v[2] = c * u[2] - s * u[1] - nose_offset - tool_length;
    world->a = joint[3] - a_factor * m.alpha;
    world->c = joint[4];
    a = world->a / a_factor;
    ca = cos(a);
    sa = sin(a);
    cc = cos(joint[4] / c_factor);
    sc = sin(joint[4] / c_factor);
    u[0] -= rotary_offset[0];
    u[1] = ca * v[1] + sa * v[2] - rotary_offset[1];
    u[2] = ca * v[2] - sa * v[1] - rotary_offset[2];
    world->x = cc * u[0] + sc * u[1] - machine_zero[0];
    world->y = cc * u[1] - sc * u[0] - machine_zero[1];
    world->z = u[2] - machine_zero[2] + tool_length;
    return 0;
}

/* Jacobian of the actuators at a solved pose: d(joints) = rates d(x, y, z, a, c), joints and pose in mm and degrees.
 *
 * From the closure equations: parallel d(x, y, z, alpha) + serial d(rho) = 0, with d P = F Rx(alpha) d g + P' d alpha.
 */
static int model_jacobian(const struct pose *world, double tool_length, const struct memory *at, double rates[5][5])
{
    struct gauge g = gauge_of(world, tool_length);
    double c = cos(at->alpha), s = sin(at->alpha), p[3], by_alpha[3], value[4], parallel[4][4], serial[4][3];
    double by_world[5][3];
    int i, j, k;
    const double t1 = g.before_tilt[1], t2 = g.before_tilt[2];
    /* derivatives of g by tip x, y, z, by A and by C, rad */
    const double of_gauge[5][3] = {
        {g.cc, g.ca * g.sc, g.sa * g.sc},
        {-g.sc, g.ca * g.cc, g.sa * g.cc},
        {0.0, -g.sa, g.ca},
        {0.0, -g.sa * t1 - g.ca * t2, g.ca * t1 - g.sa * t2},
        {-g.turned[1], g.ca * g.turned[0], g.sa * g.turned[0]},
    };
    const double per[5] = {1.0, 1.0, 1.0, 1.0 / a_factor, 1.0 / c_factor};
    point_of_tilt(g.point, c, s, p, by_alpha);
    carrier_closure(p, c, s, at->rho, value, parallel, serial);
    for (j = 0; j < 5; j++) {
        by_world[j][0] = of_gauge[j][0];
        by_world[j][1] = -(c * of_gauge[j][1] - s * of_gauge[j][2]);
        by_world[j][2] = -(s * of_gauge[j][1] + c * of_gauge[j][2]);
    }
    for (j = 0; j < 5; j++) {
        double a[4][4], b[4];
        for (i = 0; i < 4; i++) {
            b[i] = 0.0;
            a[i][3] = parallel[i][3];
            for (k = 0; k < 3; k++) {
                a[i][k] = serial[i][k];
                a[i][3] += parallel[i][k] * by_alpha[k];
                b[i] -= parallel[i][k] * by_world[j][k];
            }
        }
        if (solve_linear(4, a, b))
            return -1;
        for (k = 0; k < 3; k++)
            rates[k][j] = b[k] * per[j];
        rates[3][j] = a_factor * b[3] * per[j] + (j == 3);
        rates[4][j] = j == 4;
    }
    return 0;
}
