"""Measured comparisons: ``python -m benchmarks [GROUP ...] [--json] [--pictures DIR]``, from a checkout."""
