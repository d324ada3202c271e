"""The fuzzer: random scenes, tractions, files and arguments, each held against what is known
without the package.
"""
