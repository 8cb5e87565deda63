/* Forward and inverse kinematics of the whole machine: a spindle carrier over a tilting rotary table.
 *
 * Plain C with the mathematical library and nothing else: no memory is allocated, every loop has a largest count, and
 * a pose without a solution leaves the results untouched and returns -1. The numbers are in machine.h, the carrier in
 * carrier.h, what the component calls in whole.h, for ideal parts or as built. Equation numbers (3) to (14): Kanaan,
 * Wenger, Chablat, "Kinematics analysis of the parallel module of the VERNE machine".
 *
 * Frames: base, z down; upright = F base with F = diag(1, -1, -1). With the gauge point of the machine whose spindle
 * does not tilt,
 *     g = Rx(A) (rotary_offset + Rz(C) tip) + (0, 0, l),      l = tool length + nose offset,
 * the platform point is P = pivot + F Rx(alpha) g and the table stands at A + alpha; C does not depend on alpha.
 * mm and rad inside; a world pose and the joints are in mm and degrees, in the senses of the machine file.
 */
#ifndef MODEL_H
#define MODEL_H

#include "machine.h"

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

enum solver { CLOSED_FORM = 0, NEWTON = 1 };

/* World pose as LinuxCNC has it: tip over machine zero with the tool length added to z, nominal angles; mm, degrees. */
struct pose {
    double x, y, z, a, c;
};

/* Where Newton's method starts: the last solution, or nothing (known = 0). */
struct memory {
    int known;
    double alpha, rho[3], p[3];
    double rotation[3][3]; /* of the platform, as built alone: R beside Rx(alpha) */
};

/* Gauge point of a world pose, and its cosines and sines of A and C: for the Jacobian too. */
struct gauge {
    double point[3], before_tilt[3], turned[3];
    double ca, sa, cc, sc;
};

/* Newton's method ends when a step is below this share of a rod (or rad): the next one would be its square. */
#define SMALL_STEP 1e-8
#define NEWTON_STEPS 25
/* No step turns the platform by more, rad: it must not jump over the crossing of the rods. */
#define LARGEST_TILT_STEP 0.3
/* Rods close to this at a solution, mm2: 1e-9 mm on a rod of 950. */
#define CLOSED_MM2 (2e-6 * (CARRIER_SIZE > 850.0 ? (CARRIER_SIZE / 850.0) * (CARRIER_SIZE / 850.0) : 1.0))

/* a x = b for n unknowns, by elimination with pivots; b becomes x. -1: singular. */
static int solve_linear(int n, double a[n][n], double b[n])
{
    int i, j, k;
    for (k = 0; k < n; k++) {
        int best = k;
        for (i = k + 1; i < n; i++)
            if (fabs(a[i][k]) > fabs(a[best][k]))
                best = i;
        if (!(fabs(a[best][k]) > 0.0))
            return -1;
        if (best != k) {
            double t = b[k];
            b[k] = b[best];
            b[best] = t;
            for (j = k; j < n; j++) {
                t = a[k][j];
                a[k][j] = a[best][j];
                a[best][j] = t;
            }
        }
        for (i = k + 1; i < n; i++) {
            double f = a[i][k] / a[k][k];
            for (j = k + 1; j < n; j++)
                a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    }
    for (k = n - 1; k >= 0; k--) {
        for (j = k + 1; j < n; j++)
            b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
    return 0;
}

static int newton_forward(const double rho[3], struct memory *m);
static int is_working(const struct memory *m, double least_drop);

#include "carrier.h"

static struct gauge gauge_of(const struct pose *world, double tool_length)
{
    struct gauge g;
    double a = world->a / a_factor, c = world->c / c_factor;
    double x = world->x + machine_zero[0], y = world->y + machine_zero[1], z = world->z + machine_zero[2] - tool_length;
    g.ca = cos(a);
    g.sa = sin(a);
    g.cc = cos(c);
    g.sc = sin(c);
    g.turned[0] = g.cc * x - g.sc * y;
    g.turned[1] = g.sc * x + g.cc * y;
    g.turned[2] = z;
    g.before_tilt[0] = rotary_offset[0] + g.turned[0];
    g.before_tilt[1] = rotary_offset[1] + g.turned[1];
    g.before_tilt[2] = rotary_offset[2] + g.turned[2];
    g.point[0] = g.before_tilt[0];
    g.point[1] = g.ca * g.before_tilt[1] - g.sa * g.before_tilt[2];
    g.point[2] = g.sa * g.before_tilt[1] + g.ca * g.before_tilt[2] + nose_offset + tool_length;
    return g;
}

/* Take Newton's step from three lengths and alpha, the tilt by no more than LARGEST_TILT_STEP; returns its size. */
static double take_step(const double value[4], double lengths[3], double *alpha)
{
    double size = fabs(value[3]), shrink = 1.0;
    int k;
    if (size > LARGEST_TILT_STEP)
        shrink = LARGEST_TILT_STEP / size;
    *alpha -= shrink * value[3];
    for (k = 0; k < 3; k++) {
        lengths[k] -= shrink * value[k];
        if (fabs(value[k]) / CARRIER_SIZE > size)
            size = fabs(value[k]) / CARRIER_SIZE;
    }
    return size;
}

/* Newton on the closure equations of the carrier for P and alpha. */
static int newton_forward(const double rho[3], struct memory *m)
{
    double p[3], alpha = 0.0, value[4], parallel[4][4], serial[4][3];
    int step, k;
    if (m->known) {
        alpha = m->alpha;
        for (k = 0; k < 3; k++)
            p[k] = m->p[k];
    } else {
        carrier_guess_point(rho, p);
    }
    for (step = 0; step < NEWTON_STEPS; step++) {
        double size;
        carrier_closure(p, cos(alpha), sin(alpha), rho, value, parallel, serial);
        if (solve_linear(4, parallel, value))
            return -1;
        size = take_step(value, p, &alpha);
        if (size < SMALL_STEP) {
            m->alpha = alpha;
            for (k = 0; k < 3; k++) {
                m->p[k] = p[k];
                m->rho[k] = rho[k];
            }
            return 0;
        }
        if (!(size < 1e6))
            return -1;
    }
    return -1;
}

/* True where sliders and platform close the rods in the working mode, and no rod drops less than `least_drop`, mm. */
static int is_working(const struct memory *m, double least_drop)
{
    double value[4], parallel[4][4], serial[4][3];
    double c = cos(m->alpha), s = sin(m->alpha);
    int i;
    carrier_closure(m->p, c, s, m->rho, value, parallel, serial);
    for (i = 0; i < 4; i++)
        if (!(fabs(2.0 * value[i]) < CLOSED_MM2))
            return 0;
    return carrier_is_working(m->p, c, s, m->rho, least_drop);
}

#include "whole.h"

#endif
