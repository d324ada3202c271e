"""A measured creep curve is explained by a third body and a law of friction, fitted by gradients.

The points are on the lines of regression of 4200 samples from the roller rig of Virginia Tech and
the FRA, dry, with wear debris (N. S. M. Hosseini, A Statistical Approach to Modeling Wheel-Rail
Contact Dynamics, MSc thesis, Virginia Tech, 2020); the samples scatter about them by 219 N. The
exact theory with one coefficient of friction is too stiff. An elastic layer of debris gives the
slope, and a law by the pressure, f = f0 (1 - part that ...), is tried for what is left. Each curve
comes with its derivatives by all parameters, one transposed solve a point.

Lengths in m, forces in N. Run: python examples/fitted_creep_curve.py [picture.png]
"""
