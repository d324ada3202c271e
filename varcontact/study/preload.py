"""What a process that solves scenes needs, to be imported before it is forked: the package, and SciPy's parts."""

from importlib import import_module

for name in ("psutil", "scipy.fft", "scipy.linalg", "scipy.special", "varcontact.study.sweep"):
    import_module(name)
