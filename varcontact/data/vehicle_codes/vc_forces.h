/* Made by varcontact $version: creep forces of an elliptic contact in steady rolling, from a table of exact solutions.
 *
 * in[9], in any consistent units, with a length L and a force F:
 *   0  a      semi-axis along the rolling direction [L]
 *   1  b      semi-axis across it [L]
 *   2  G      combined modulus of rigidity [F/L^2]
 *   3  nu     combined Poisson's ratio, within 0.01 of $nu
 *   4  Fz     normal force [F]
 *   5  f      coefficient of friction
 *   6  vx     longitudinal creepage
 *   7  vy     lateral creepage
 *   8  spin   [1/L]
 * out[3], on body 1:
 *   0  Fx [F]   1  Fy [F]   2  Mz [F L], about the centre of the contact
 * vc_forces_gradient writes out[12]: the forces, then by rows the derivatives of Fx, Fy and Mz by vx, vy and spin.
 * Closer than 0.001 of the reduced creepage to pure vx, the derivatives are those at this distance.
 *
 * Both return 0; or 1, if a/b is outside [$least, $greatest]: the forces are then those of the ellipse
 * of the same area with the nearest a/b; or a negative code, and out is NaN.
 * They keep no state and may be called from several threads.
 * Do not compile with -ffast-math, which does not recognise NaN.
 *
 * Errors: Fx and Fy relative to f Fz, Mz relative to f Fz sqrt(ab). The largest estimated error of the $entries exact
 * solutions in the table is VC_ENTRY_ERROR.$between
 * As creepages grow, forces tend to those of full slip in closed form, without a limit of the table.
 */
#ifndef VC_FORCES_H
#define VC_FORCES_H

#define VC_NU $nu
#define VC_LEAST_RATIO $least
#define VC_GREATEST_RATIO $greatest
#define VC_ENTRY_ERROR $error
#define VC_BOOK "$token"

#define VC_OK 0
#define VC_NEAREST_RATIO 1
#define VC_NOT_FINITE (-1)
#define VC_NOT_POSITIVE (-2)
#define VC_OTHER_NU (-3)

#ifdef __cplusplus
extern "C" {
#endif

int vc_forces(const double *in, double *out);
int vc_forces_gradient(const double *in, double *out);
const char *vc_message(int status);

#ifdef __cplusplus
}
#endif

#endif
