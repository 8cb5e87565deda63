/* Three Cartesian axes that carry an upright spindle: (x, y, z) = F (P - zero), F = diag(1, -1, -1); alpha = 0.
 *
 * Base frame, z down; mm. zero (machine.h): where P stands at x = y = z = 0.
 */
#define CARRIER_SIZE 1000.0
static const double upright[3] = {1.0, -1.0, -1.0};

static void carrier_closure(const double p[3], double c, double s, const double rho[3], double value[4], double parallel[4][4], double serial[4][3])
{
    int i, k;
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++) {
            parallel[i][k] = i == k ? upright[k] : 0.0;
            serial[i][k] = i == k ? -1.0 : 0.0;
        }
        parallel[i][3] = i == 3;
    }
    for (i = 0; i < 3; i++)
        value[i] = upright[i] * (p[i] - zero[i]) - rho[i];
    value[3] = atan2(s, c);
}

static int carrier_is_working(const double p[3], double c, double s, const double rho[3], double least_drop)
{
    (void)p;
    (void)c;
    (void)s;
    (void)rho;
    (void)least_drop;
    return 1;
}

static void carrier_guess_sliders(const double p[3], double rho[3])
{
    int k;
    for (k = 0; k < 3; k++)
        rho[k] = upright[k] * (p[k] - zero[k]);
}

static void carrier_guess_point(const double rho[3], double p[3])
{
    int k;
    for (k = 0; k < 3; k++)
        p[k] = zero[k] + upright[k] * rho[k];
}

static int carrier_inverse(const double g[3], struct memory *m)
{
    m->alpha = 0.0;
    m->p[0] = pivot[0] + g[0];
    m->p[1] = pivot[1] - g[1];
    m->p[2] = pivot[2] - g[2];
    carrier_guess_sliders(m->p, m->rho);
    return 0;
}

static int carrier_forward(const double rho[3], struct memory *m)
{
    int k;
    m->alpha = 0.0;
    carrier_guess_point(rho, m->p);
    for (k = 0; k < 3; k++)
        m->rho[k] = rho[k];
    return 0;
}
