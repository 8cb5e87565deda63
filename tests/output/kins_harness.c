/* The kinematics of an exported machine as functions of arrays, for ctypes: poses are x, y, z, a, c; mm, degrees. */
#include <math.h>
#include <time.h>

#include "model.h"

static struct pose pose_of(const double *row)
{
    struct pose one = {row[0], row[1], row[2], row[3], row[4]};
    return one;
}

/* keep: the memory goes from row to row, as in a servo thread. */
void inverse_rows(int n, const double *world, const double *tool, int solver, int keep, double *joint, int *ok)
{
    struct memory m = {0};
    int k;
    for (k = 0; k < n; k++) {
        struct pose one = pose_of(world + 5 * k);
        if (!keep)
            m.known = 0;
        ok[k] = model_inverse(&one, tool[k], solver, &m, joint + 5 * k) == 0;
    }
}

void forward_rows(int n, const double *joint, const double *tool, int solver, int keep, double *world, int *ok)
{
    struct memory m = {0};
    int k;
    for (k = 0; k < n; k++) {
        struct pose one = {NAN, NAN, NAN, NAN, NAN};
        if (!keep)
            m.known = 0;
        ok[k] = model_forward(joint + 5 * k, tool[k], solver, &m, &one) == 0;
        world[5 * k] = one.x, world[5 * k + 1] = one.y, world[5 * k + 2] = one.z;
        world[5 * k + 3] = one.a, world[5 * k + 4] = one.c;
    }
}

void jacobian_rows(int n, const double *world, const double *tool, double *rates, int *ok)
{
    int k;
    for (k = 0; k < n; k++) {
        struct memory m = {0};
        struct pose one = pose_of(world + 5 * k);
        double joint[5];
        ok[k] = !model_inverse(&one, tool[k], CLOSED_FORM, &m, joint)
            && !model_jacobian(&one, tool[k], &m, (double (*)[5])(rates + 25 * k));
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Nanoseconds of one solution of each row, the shortest of several measurements of `many` in a row; rows that fail too.
 * warm: every solution starts from that of the row `other`, beside it, and not from nothing. */
void time_rows(int n, const double *rows, const double *other, const double *tool, int forward, int solver, int warm, int many, double *ns)
{
    double out[5], best, begin;
    volatile double sink = 0.0;
    int k, j, run;
    for (k = 0; k < n; k++) {
        struct memory before = {0}, m;
        struct pose one = pose_of(rows + 5 * k), near = pose_of(other + 5 * k), found;
        if (warm && (forward ? model_forward(other + 5 * k, tool[k], CLOSED_FORM, &before, &found)
                             : model_inverse(&near, tool[k], CLOSED_FORM, &before, out))) {
            ns[k] = NAN;
            continue;
        }
        best = 1e30;
        for (run = 0; run < 5; run++) {
            begin = now();
            for (j = 0; j < many; j++) {
                m = before;
                if (forward)
                    sink += model_forward(rows + 5 * k, tool[k], solver, &m, &found) ? 0.0 : found.x;
                else
                    sink += model_inverse(&one, tool[k], solver, &m, out) ? 0.0 : out[0];
            }
            begin = (now() - begin) / many;
            best = begin < best ? begin : best;
        }
        ns[k] = best;
    }
}
