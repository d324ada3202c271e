"""Kalker's rolling contact of elastic bodies as convex optimisation, with a certificate of exactness.

The public names are listed in ``__init__.pyi``; each is imported when it is first used, so that `import varcontact` is
quick.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
