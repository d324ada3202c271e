"""What a process that solves scenes needs, to be imported before it is forked: the package, and SciPy's parts."""

import psutil  # noqa: F401
import scipy.fft
import scipy.linalg
import scipy.special  # noqa: F401

import varcontact.study.sweep  # noqa: F401
