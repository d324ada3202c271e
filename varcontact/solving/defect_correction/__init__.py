"""Steady rolling under Hertz's pressure, corrected on its own grid towards the continuum: ``refine="continuum"``."""
