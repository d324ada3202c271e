"""What docs/sampling.md says was tried and left out.

python -m tests.benchmarks.sampling_tried TABLE   # linear, strips, normal, cut, unlike, time, histories, levels
"""
