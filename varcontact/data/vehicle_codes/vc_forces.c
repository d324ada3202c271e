/* Made by varcontact $version. See vc_forces.h.
 *
 * The table is made by: $provenance
 */
#include "vc_forces.h"

#include <float.h>
#include <math.h>

#define PI 3.14159265358979323846
#define SMALL 1e-100
#define LARGE 1e100
#define HALFWAY $HALFWAY
#define KNEE $KNEE
#define ROOM $ROOM
#define SPIN $SPIN
#define MORE $MORE
#define NEAR_PURE_VX 1e-3

/* B-splines of log(a/b), of the place of t, of the angle from vx, and of the angle of (vy, spin) */
enum { RATIOS = $ratios, PLACES = $places, POLAR = $polar, ANGLES = $angles, FULL = $full };

/* Whole multiples of units, by place and component; those at full slip are finer by the part MORE. */
static const short multiples[RATIOS * PLACES * POLAR * ANGLES * 3];
static const short at_full_slip[RATIOS * FULL * POLAR * ANGLES * 3];
static const double units[PLACES * 3];

/* Scaled creepage coefficients: B-splines of log(a/b) from -COEFFICIENT_END to COEFFICIENT_END */
#define COEFFICIENT_END $end
enum { COEFFICIENTS = $coefficient_rows };
static const double coefficients[COEFFICIENTS * 4];

typedef struct {
    int first;                        /* of four splines of log(a/b) */
    double weight[4];                 /* of these */
    double scale[3];                  /* of vx, vy and spin sqrt(ab) in the reduced creepage */
    double by_vy[3], by_spin[3];      /* linear theory: forces by the second and third reduced creepage */
} Ellipse;

/* The four B-splines that are not zero at a place, and their slopes; returns the number of the first. */
static int near_splines(double place, int intervals, double value[4], double slope[4])
{
    int first = place > 0 ? (int)place : 0;
    if (first > intervals - 1) first = intervals - 1;
    double f = place - first, g = 1 - f, ff = f * f / 6, gg = g * g / 6;
    value[0] = g * gg;
    value[1] = (3 * f - 6) * ff + 2.0 / 3;
    value[2] = (3 * g - 6) * gg + 2.0 / 3;
    value[3] = f * ff;
    slope[0] = -3 * gg;
    slope[1] = (1.5 * f - 2) * f;
    slope[2] = -(1.5 * g - 2) * g;
    slope[3] = 3 * ff;
    return first;
}

static Ellipse ellipse(double ratio)
{
    Ellipse e;
    double slope[4], weight[4], scaled[4] = {0, 0, 0, 0}, x = log(ratio), root = hypot(1, ratio);
    int first = near_splines((x + COEFFICIENT_END) * ((COEFFICIENTS - 3) / (2 * COEFFICIENT_END)),
                             COEFFICIENTS - 3, weight, slope);
    for (int k = 0; k < 4; k++)
        for (int c = 0; c < 4; c++) scaled[c] += weight[k] * coefficients[(first + k) * 4 + c];
    double C11 = root / scaled[0], C22 = root / scaled[1], C23 = sqrt(ratio) * root * scaled[2],
           C33 = root / ratio * scaled[3];
    e.scale[0] = C11;
    e.scale[1] = C22;
    e.scale[2] = SPIN * C11 * sqrt(ratio + 1 / ratio);
    e.by_vy[0] = 0;
    e.by_vy[1] = -1;
    e.by_vy[2] = C23 / C22;
    e.by_spin[0] = 0;
    e.by_spin[1] = -C23 / e.scale[2];
    e.by_spin[2] = -C33 / e.scale[2];
    e.first = near_splines(log(ratio / VC_LEAST_RATIO) * ((RATIOS - 3) / log(VC_GREATEST_RATIO / VC_LEAST_RATIO)),
                           RATIOS - 3, e.weight, slope);
    return e;
}

/* The sum S of the splines, S[0], and its derivatives by the places of t and of both angles. */
static void spline_sum(const Ellipse *e, const double place[3], double S[4][3])
{
    double wt[4], dt[4], wp[4], dp[4], wa[4], da[4];
    int i0 = near_splines(place[0], PLACES - 3, wt, dt);
    int j0 = near_splines(place[1], POLAR - 3, wp, dp);
    int k0 = near_splines(place[2], ANGLES - 3, wa, da);
    for (int n = 0; n < 4; n++)
        for (int c = 0; c < 3; c++) S[n][c] = 0;
    for (int h = 0; h < 4; h++)
        for (int i = 0; i < 4; i++) {
            int t = i0 + i, full = t - (PLACES - FULL), at = (j0 * ANGLES + k0) * 3;
            const short *row = multiples + ((e->first + h) * PLACES + t) * POLAR * ANGLES * 3 + at;
            const short *fine = full < 0 ? 0 : at_full_slip + ((e->first + h) * FULL + full) * POLAR * ANGLES * 3 + at;
            double sum[3] = {0, 0, 0}, by_polar[3] = {0, 0, 0}, by_angle[3] = {0, 0, 0};
            for (int j = 0; j < 4; j++) {
                double value[3] = {0, 0, 0}, slope[3] = {0, 0, 0};
                for (int k = 0; k < 4; k++)
                    for (int c = 0; c < 3; c++) {
                        int n = (j * ANGLES + k) * 3 + c;
                        double multiple = fine ? row[n] + fine[n] / MORE : row[n];
                        value[c] += wa[k] * multiple;
                        slope[c] += da[k] * multiple;
                    }
                for (int c = 0; c < 3; c++) {
                    sum[c] += wp[j] * value[c];
                    by_polar[c] += dp[j] * value[c];
                    by_angle[c] += wp[j] * slope[c];
                }
            }
            for (int c = 0; c < 3; c++) {
                double unit = e->weight[h] * units[t * 3 + c];
                S[0][c] += unit * wt[i] * sum[c];
                S[1][c] += unit * dt[i] * sum[c];
                S[2][c] += unit * wt[i] * by_polar[c];
                S[3][c] += unit * wt[i] * by_angle[c];
            }
        }
}

/* Forces by f Fz, and their derivatives D, of reduced creepages u, as TableBook._normalised in Python. */
static void normalised(const Ellipse *e, const double u[3], double F[3], double D[3][3])
{
    double x = u[0], y = u[1], z = u[2], across = y * y + z * z, away = sqrt(across);
    double size = sqrt(x * x + across), rest = HALFWAY / (size + HALFWAY), t = 1 - rest;
    double angle = atan2(z, y), steps = PLACES - 3, polar = (POLAR - 3) * 2 / PI, half_turn = ANGLES - 3;
    double cube = t * t * t, w = (1 - t) * (KNEE / HALFWAY), both = cube + w * w * w;
    double place[3] = {(t + ROOM * (cube / both - t)) * steps, atan2(away, fabs(x)) * polar,
                       (angle * (1 / PI) + (angle < 0) - (angle >= PI)) * half_turn};
    double turn = angle < 0 || angle >= PI ? -1 : 1, sign[3] = {x < 0 ? -1 : 1, turn, turn};
    double S[4][3], L[3];
    spline_sum(e, place, S);
    for (int i = 0; i < 3; i++) {
        L[i] = (i == 0 ? -x : 0) + e->by_vy[i] * y + e->by_spin[i] * z;
        F[i] = sign[i] * t * t * S[0][i] + rest * rest * L[i];
    }
    if (D) {
        double t_by_size = rest * rest / HALFWAY, square = size * size;
        double place_by_t = steps * (1 + ROOM * (3 * t * t * w * w * (w + t * (KNEE / HALFWAY)) / (both * both) - 1));
        for (int k = 0; k < 3; k++) {
            const double *by = k == 1 ? e->by_vy : e->by_spin;
            double dt = 0, dplace[3] = {0, 0, 0};
            if (size > SMALL) {
                dt = t_by_size * u[k] / size;
                dplace[0] = place_by_t * dt;
                if (k == 0) dplace[1] = -polar * away * sign[0] / square;
                else if (away > 0) {
                    dplace[1] = polar * fabs(x) / square * (u[k] / away);
                    dplace[2] = half_turn / PI * (k == 1 ? -z : y) / across;
                }
            }
            for (int i = 0; i < 3; i++) {
                double dS = S[1][i] * dplace[0] + S[2][i] * dplace[1] + S[3][i] * dplace[2];
                D[i][k] = sign[i] * t * (2 * dt * S[0][i] + t * dS) - 2 * rest * dt * L[i]
                          + rest * rest * (k == 0 ? (i == 0 ? -1 : 0) : by[i]);
            }
        }
        if (across < NEAR_PURE_VX * NEAR_PURE_VX * x * x) { /* where an angle has no direction */
            double aside[2][3] = {{x, NEAR_PURE_VX * size, 0}, {x, 0, NEAR_PURE_VX * size}}, other[3], found[2][3][3];
            for (int n = 0; n < 2; n++) normalised(e, aside[n], other, found[n]);
            for (int i = 0; i < 3; i++) {
                for (int k = 0; k < 2; k++) D[i][k] = found[0][i][k];
                D[i][2] = found[1][i][2];
            }
            D = 0; /* they are cut */
        }
    }
    double force = sqrt(F[0] * F[0] + F[1] * F[1]);
    if (force > 1) {
        for (int k = 0; D && k < 3; k++) {
            double along = (F[0] * D[0][k] + F[1] * D[1][k]) / (force * force);
            for (int i = 0; i < 2; i++) D[i][k] = (D[i][k] - along * F[i]) / force;
        }
        F[0] /= force;
        F[1] /= force;
    }
}

static int refused(int status, double *out, int count)
{
    for (int i = 0; i < count; i++) out[i] = NAN;
    return status;
}

static int forces(const double *in, double *out, int gradient)
{
    int status = VC_OK, count = gradient ? 12 : 3;
    for (int i = 0; i < 9; i++)
        if (!(fabs(in[i]) <= LARGE)) return refused(VC_NOT_FINITE, out, count);
    for (int i = 0; i < 6; i++)
        if (i != 3 && !(in[i] >= SMALL)) return refused(VC_NOT_POSITIVE, out, count);
    if (fabs(in[3] - VC_NU) > $near) return refused(VC_OTHER_NU, out, count);
    double ratio = in[0] / in[1], area = in[0] * in[1], length = sqrt(area), limit = in[4] * in[5];
    if (ratio < VC_LEAST_RATIO * (1 - 1e-12) || ratio > VC_GREATEST_RATIO * (1 + 1e-12)) status = VC_NEAREST_RATIO;
    ratio = fmin(fmax(ratio, VC_LEAST_RATIO), VC_GREATEST_RATIO);
    Ellipse e = ellipse(ratio);
    double unit = in[2] * area / limit, by[3] = {unit * e.scale[0], unit * e.scale[1], unit * length * e.scale[2]};
    double u[3] = {by[0] * in[6], by[1] * in[7], by[2] * in[8]}, F[3], D[3][3];
    if (!(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] <= DBL_MAX)) return refused(VC_NOT_FINITE, out, count);
    normalised(&e, u, F, gradient ? D : 0);
    for (int i = 0; i < 3; i++) {
        double size = i == 2 ? limit * length : limit;
        out[i] = size * F[i];
        for (int k = 0; gradient && k < 3; k++) out[3 + 3 * i + k] = size * D[i][k] * by[k];
    }
    return status;
}

int vc_forces(const double *in, double *out)
{
    return forces(in, out, 0);
}

int vc_forces_gradient(const double *in, double *out)
{
    return forces(in, out, 1);
}

const char *vc_message(int status)
{
    switch (status) {
    case VC_OK: return "";
    case VC_NEAREST_RATIO: return "a/b is outside the table: forces are those of the nearest a/b in it";
    case VC_NOT_FINITE: return "an input is not finite, or too large to compute with";
    case VC_NOT_POSITIVE: return "a, b, G, Fz and f must be positive";
    case VC_OTHER_NU: return "nu must be within 0.01 of that of the table";
    default: return "unknown status";
    }
}

static const double units[] = {
$units_data
};

static const double coefficients[] = {
$coefficients_data
};

static const short at_full_slip[] = {
$at_full_slip_data
};

static const short multiples[] = {
$multiples_data
};
