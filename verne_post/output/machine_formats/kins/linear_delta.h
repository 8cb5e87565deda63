/* A linear delta: three vertical sliders, three parallelograms, a platform that never tilts (alpha = 0).
 *
 * Leg i is (x - X_i)^2 + (y - Y_i)^2 + (z - rho_i)^2 = L^2. Working mode: every slider joint above the
 * platform, and P below the plane of the three sphere centres. Base frame, z down; mm.
 */
#define CARRIER_SIZE rod_length

/* (X_i, Y_i) = (base radius - platform radius) (cos theta_i, sin theta_i): constants that the compiler works out. */
static inline void place_feet(double foot[3][2])
{
    int i;
    for (i = 0; i < 3; i++) {
        foot[i][0] = (base_radius - platform_radius) * cos(leg_angles_deg[i] * (M_PI / 180.0));
        foot[i][1] = (base_radius - platform_radius) * sin(leg_angles_deg[i] * (M_PI / 180.0));
    }
}

/* Drop of the rods with P on the axis. */
static inline double middle_drop(void)
{
    return sqrt(rod_length * rod_length - (base_radius - platform_radius) * (base_radius - platform_radius));
}

/* Halves of the three rod equations, and alpha = 0; their derivatives by x, y, z, alpha and by the sliders. */
static void carrier_closure(const double p[3], double c, double s, const double rho[3], double value[4], double parallel[4][4], double serial[4][3])
{
    double foot[3][2];
    int i, k;
    place_feet(foot);
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++)
            parallel[i][k] = serial[i][k] = 0.0;
        parallel[i][3] = i == 3;
    }
    for (i = 0; i < 3; i++) {
        double dx = p[0] - foot[i][0], dy = p[1] - foot[i][1], dz = p[2] - rho[i];
        value[i] = 0.5 * (dx * dx + dy * dy + dz * dz - rod_length * rod_length);
        parallel[i][0] = dx;
        parallel[i][1] = dy;
        parallel[i][2] = dz;
        serial[i][i] = -dz;
    }
    value[3] = atan2(s, c);
}

/* Sliders above the platform by at least so much, and P below the plane of the sphere centres. */
static int carrier_is_working(const double p[3], double c, double s, const double rho[3], double least_drop)
{
    double foot[3][2], u[3], v[3], w[3], side, triple;
    int i;
    place_feet(foot);
    (void)c;
    (void)s;
    for (i = 0; i < 3; i++)
        if (!(p[2] - rho[i] > least_drop))
            return 0;
    u[0] = p[0] - foot[0][0], u[1] = p[1] - foot[0][1], u[2] = p[2] - rho[0];
    v[0] = p[0] - foot[1][0], v[1] = p[1] - foot[1][1], v[2] = p[2] - rho[1];
    w[0] = p[0] - foot[2][0], w[1] = p[1] - foot[2][1], w[2] = p[2] - rho[2];
    side = (foot[1][0] - foot[0][0]) * (foot[2][1] - foot[0][1]) - (foot[1][1] - foot[0][1]) * (foot[2][0] - foot[0][0]);
    triple = u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
    return side * triple > 0.0;
}

static void carrier_guess_sliders(const double p[3], double rho[3])
{
    rho[0] = rho[1] = rho[2] = p[2] - middle_drop();
}

static void carrier_guess_point(const double rho[3], double p[3])
{
    p[0] = p[1] = 0.0;
    p[2] = (rho[0] + rho[1] + rho[2]) / 3.0 + middle_drop();
}

/* rho_i = z - sqrt(L^2 - (x - X_i)^2 - (y - Y_i)^2). */
static int carrier_inverse(const double g[3], struct memory *m)
{
    double foot[3][2];
    int i;
    place_feet(foot);
    m->alpha = 0.0;
    m->p[0] = pivot[0] + g[0];
    m->p[1] = pivot[1] - g[1];
    m->p[2] = pivot[2] - g[2];
    for (i = 0; i < 3; i++) {
        double dx = m->p[0] - foot[i][0], dy = m->p[1] - foot[i][1], square = rod_length * rod_length - dx * dx - dy * dy;
        if (!(square > 0.0))
            return -1;
        m->rho[i] = m->p[2] - sqrt(square);
    }
    return 0;
}

/* The lower meeting point of three spheres about B_i = (X_i, Y_i, rho_i): with u = B2 - B1, v = B3 - B1 and
 * n = u x v, the centre of the circle is M = B1 + (|u|^2 v - |v|^2 u) x n / (2 |n|^2), and P = M + h n / |n|. */
static int carrier_forward(const double rho[3], struct memory *m)
{
    double foot[3][2], u[3], v[3], n[3], d[3], out[3], u2, v2, n2, square, height;
    int k;
    place_feet(foot);
    u[0] = foot[1][0] - foot[0][0], u[1] = foot[1][1] - foot[0][1], u[2] = rho[1] - rho[0];
    v[0] = foot[2][0] - foot[0][0], v[1] = foot[2][1] - foot[0][1], v[2] = rho[2] - rho[0];
    n[0] = u[1] * v[2] - u[2] * v[1], n[1] = u[2] * v[0] - u[0] * v[2], n[2] = u[0] * v[1] - u[1] * v[0];
    u2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    n2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    for (k = 0; k < 3; k++)
        d[k] = u2 * v[k] - v2 * u[k];
    out[0] = (d[1] * n[2] - d[2] * n[1]) / (2.0 * n2);
    out[1] = (d[2] * n[0] - d[0] * n[2]) / (2.0 * n2);
    out[2] = (d[0] * n[1] - d[1] * n[0]) / (2.0 * n2);
    square = rod_length * rod_length - (out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    if (!(square > 0.0))
        return -1;
    height = (n[2] > 0.0 ? 1.0 : -1.0) * sqrt(square / n2);
    m->alpha = 0.0;
    m->p[0] = foot[0][0] + out[0] + height * n[0];
    m->p[1] = foot[0][1] + out[1] + height * n[1];
    m->p[2] = rho[0] + out[2] + height * n[2];
    for (k = 0; k < 3; k++)
        m->rho[k] = rho[k];
    return 0;
}
