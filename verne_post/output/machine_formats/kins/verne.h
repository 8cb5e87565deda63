/* The parallel module of the VERNE: three vertical sliders, six rods, a platform that tilts about x by alpha.
 *
 * In the working mode every slider joint is above the platform's (s1 = s2 = s3 = -1) and the rods of leg I are
 * uncrossed (R1 cos alpha > r1). Base frame, z down; mm, rad. c and s: cosine and sine of alpha.
 */
#define CARRIER_SIZE L1
#define HALLEY_STEPS 6
#define BRACKET_STEPS 60
/* Halley's step is the last when the one after it, which its own bend tells, is below this, rad. */
#define TILT_STEP 5e-6
#define TILT_ERROR 1e-17
/* The bracket ends when it is this narrow, rad, or (14) holds to rounding, mm2. */
#define TILT_WIDTH 4e-16
#define LOOP_ROUNDING 1e-10

/* Halves of the left-hand sides of (3), (4), (5), (6), and their derivatives by x, y, z, alpha and by the sliders. */
static void carrier_closure(const double p[3], double c, double s, const double rho[3], double value[4], double parallel[4][4], double serial[4][3])
{
    const double offset[4] = {leg1_x_offset, leg1_x_offset, leg23_x_offset, leg23_x_offset};
    const double radius[4] = {R1, -R1, -R2, R2}, base[4] = {r1, -r1, -r4, r4}, rod[4] = {L1, L1, L2, L3};
    static const int slider[4] = {0, 0, 1, 2};
    int i;
    for (i = 0; i < 4; i++) {
        double dx = p[0] + offset[i];
        double dy = p[1] + radius[i] * c - base[i];
        double dz = p[2] + radius[i] * s - rho[slider[i]];
        value[i] = 0.5 * (dx * dx + dy * dy + dz * dz - rod[i] * rod[i]);
        parallel[i][0] = dx;
        parallel[i][1] = dy;
        parallel[i][2] = dz;
        parallel[i][3] = radius[i] * (dz * c - dy * s);
        serial[i][0] = serial[i][1] = serial[i][2] = 0.0;
        serial[i][slider[i]] = -dz;
    }
}

/* Working mode, and drops of the legs of at least so much. */
static int carrier_is_working(const double p[3], double c, double s, const double rho[3], double least_drop)
{
    return R1 * c > r1 && p[2] - rho[0] > least_drop && p[2] - R2 * s - rho[1] > least_drop && p[2] + R2 * s - rho[2] > least_drop;
}

/* Drops of the three legs in the middle of the workspace, upright: constants that the compiler works out. */
static void middle_drops(double drop[3])
{
    const double across = 0.5 * (leg1_x_offset - leg23_x_offset);
    drop[0] = sqrt(fmax(L1 * L1 - (R1 - r1) * (R1 - r1) - across * across, 0.0625 * L1 * L1));
    drop[1] = sqrt(fmax(L2 * L2 - (R2 - r4) * (R2 - r4) - across * across, 0.0625 * L2 * L2));
    drop[2] = sqrt(fmax(L3 * L3 - (R2 - r4) * (R2 - r4) - across * across, 0.0625 * L3 * L3));
}

/* Where Newton's method starts without a solution before: sliders over P, and P under the sliders, as in the middle. */
static inline void carrier_guess_sliders(const double p[3], double rho[3])
{
    int k;
    middle_drops(rho);
    for (k = 0; k < 3; k++)
        rho[k] = p[2] - rho[k];
}

static void carrier_guess_point(const double rho[3], double p[3])
{
    double drop[3];
    middle_drops(drop);
    p[0] = -0.5 * (leg1_x_offset + leg23_x_offset);
    p[1] = 0.0;
    p[2] = (rho[0] + drop[0] + rho[1] + drop[1] + rho[2] + drop[2]) / 3.0;
}

/* Equation (14) in the working mode, with the radicand of (11) cut off at zero. */
static double loop_of_tilt(double x1, double y0, double yc, double ys, double alpha, double *radicand)
{
    double c = cos(alpha), s = sin(alpha), y = y0 + yc * c + ys * s;
    *radicand = L1 * L1 - (R1 * R1 + r1 * r1 - 2.0 * R1 * r1 * c) - x1 * x1 - y * y;
    return y * (R1 * c - r1) + R1 * s * sqrt(*radicand > 0.0 ? *radicand : 0.0);
}

/* Inverse in closed form up to one number: the sine of alpha, the root of (14), then (11), (12), (13).
 *
 * P = pivot + F Rx(alpha) g: x does not depend on alpha, y = y0 + yc cos alpha + ys sin alpha. Halley's method from
 * alpha = 0; near the rim, where it fails, the bracket between the crossings of the rods, narrowed by
 * secants of which every fourth is a bisection.
 */
static int carrier_inverse(const double g[3], struct memory *m)
{
    double x = pivot[0] + g[0], y0 = pivot[1], yc = -g[1], ys = g[2];
    double x1 = x + leg1_x_offset, x2 = x + leg23_x_offset;
    double constant = L1 * L1 - R1 * R1 - r1 * r1 - x1 * x1;
    double c = 1.0, s = 0.0, y, z, arm, m1, m2, m3;
    int k, found = 0;
    for (k = 0; k < HALLEY_STEPS && !found; k++) {
        double dy, ddy, root, droot, ddroot, f, df, ddf, newton, bend, step;
        y = y0 + yc * c + ys * s;
        dy = ys * c - yc * s;
        ddy = y0 - y;
        arm = R1 * c - r1;
        root = sqrt(constant + 2.0 * R1 * r1 * c - y * y);
        droot = -(R1 * r1 * s + y * dy) / root;
        ddroot = -(R1 * r1 * c + dy * dy + y * ddy + droot * droot) / root;
        f = y * arm + R1 * s * root;
        df = dy * arm + R1 * (c * root + s * (droot - y));
        ddf = ddy * arm + R1 * (c * (2.0 * droot - y) + s * (ddroot - root - 2.0 * dy));
        newton = f / df;
        bend = 0.5 * newton * (ddf / df + s / c);
        step = c * newton / (1.0 - bend);
        s -= step;
        c = sqrt(1.0 - s * s);
        found = fabs(step) < TILT_STEP && fabs(step) * bend * bend < TILT_ERROR;
    }
    m->alpha = asin(s);
    if (!found || !(R1 * c > r1)) {
        double low = -acos(r1 / R1), high = -low, radicand;
        double below = loop_of_tilt(x1, y0, yc, ys, low, &radicand), above = loop_of_tilt(x1, y0, yc, ys, high, &radicand);
        int side = 0;
        for (k = 0; k < BRACKET_STEPS && high - low > TILT_WIDTH; k++) {
            double at = 0.5 * (low + high), value;
            if (k % 4 != 3 && below < 0.0 && above > 0.0)
                at = low + (high - low) * (below / (below - above));
            value = loop_of_tilt(x1, y0, yc, ys, at, &radicand);
            if (fabs(value) <= LOOP_ROUNDING)
                low = high = at;
            else if (value > 0.0) {
                high = at;
                above = value;
                below *= side > 0 ? 0.5 : 1.0;
                side = 1;
            } else {
                low = at;
                below = value;
                above *= side < 0 ? 0.5 : 1.0;
                side = -1;
            }
        }
        m->alpha = 0.5 * (low + high);
        c = cos(m->alpha);
        s = sin(m->alpha);
    }
    y = y0 + yc * c + ys * s;
    z = pivot[2] - (s * g[1] + c * g[2]);
    arm = R2 * c - r4;
    m1 = constant + 2.0 * R1 * r1 * c - y * y;
    m2 = L2 * L2 - x2 * x2 - (y - arm) * (y - arm);
    m3 = L3 * L3 - x2 * x2 - (y + arm) * (y + arm);
    if (!(m1 > 0.0 && m2 > 0.0 && m3 > 0.0))
        return -1;
    m->rho[0] = z - sqrt(m1);          /* (11) */
    m->rho[1] = z - R2 * s - sqrt(m2); /* (12) */
    m->rho[2] = z + R2 * s - sqrt(m3); /* (13) */
    m->p[0] = x;
    m->p[1] = y;
    m->p[2] = z;
    return 0;
}

/* Forward in closed form up to one number: alpha, the root of (5) - (6).
 *
 * (14) gives y = t w by the drop w = z - rho1 of leg I, t = -R1 sin alpha / (R1 cos alpha - r1). Half of (5) + (6)
 * minus (10) has no squares: x1 = x + D1 - d1 = (T - sigma w) / (2 X), X the distance of the legs along x. Put into
 * (10), that is one quadratic for w. Newton's method for alpha from 0; where it fails, in four unknowns.
 */
static int carrier_forward(const double rho[3], struct memory *m)
{
    const double X = leg23_x_offset - leg1_x_offset;
    double half = 0.5 * (rho[2] - rho[1]), sigma = 2.0 * rho[0] - rho[1] - rho[2], alpha = 0.0;
    int k, j;
    for (k = 0; k < NEWTON_STEPS && X != 0.0; k++) {
        double c = cos(alpha), s = sin(alpha), arm1 = R1 * c - r1, arm = R2 * c - r4, h = half - R2 * s;
        double t = -R1 * s / arm1, dt = -R1 * (R1 - r1 * c) / (arm1 * arm1);
        double q = L1 * L1 - (R1 * R1 + r1 * r1 - 2.0 * R1 * r1 * c), dq = -2.0 * R1 * r1 * s;
        double T = 0.5 * (L2 * L2 + L3 * L3) - arm * arm - h * h - q - X * X - 0.25 * sigma * sigma;
        double dT = 2.0 * (arm * R2 * s + h * R2 * c) - dq;
        double u = 0.5 / (X * X), A = 1.0 + t * t + 0.5 * u * sigma * sigma, B = u * sigma * T, C = 0.5 * u * T * T - q;
        double root = sqrt(B * B - 4.0 * A * C), w = (B + root) / (2.0 * A);
        double dw = (u * sigma * dT * w - 2.0 * t * dt * w * w - (u * T * dT - dq)) / root;
        double y = t * w, dy = dt * w + t * dw, zm = w + 0.5 * sigma;
        double f = zm * h - y * arm - 0.25 * (L2 * L2 - L3 * L3);
        double df = dw * h - zm * R2 * c - dy * arm + y * R2 * s;
        double step = f / df;
        if (!(fabs(step) < 1e6))
            break;
        if (fabs(step) > LARGEST_TILT_STEP)
            step *= LARGEST_TILT_STEP / fabs(step);
        alpha -= step;
        if (fabs(step) < SMALL_STEP) {
            /* w at the last alpha but one, carried to the last: what is left is the square of the step */
            w -= dw * step;
            y -= dy * step;
            m->alpha = alpha;
            m->p[0] = (T - dT * step - sigma * w) / (2.0 * X) - leg1_x_offset;
            m->p[1] = y;
            m->p[2] = rho[0] + w;
            for (j = 0; j < 3; j++)
                m->rho[j] = rho[j];
            if (is_working(m, 0.0))
                return 0;
            break;
        }
    }
    m->known = 0;
    return newton_forward(rho, m);
}
