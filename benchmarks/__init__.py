"""Measured comparisons, from a checkout: ``python -m benchmarks [GROUP ...] [--json] [--pictures DIR]``."""
