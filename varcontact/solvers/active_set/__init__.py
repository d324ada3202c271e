"""Kalker's own algorithms, NORM and TANG, by hand (paper, sections 5.2 and 5.3)."""
