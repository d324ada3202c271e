"""The machine: free memory, threads, locks, signals, and files that may be damaged."""
