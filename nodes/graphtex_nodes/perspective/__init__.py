"""Perspective-aware analysis and synthesis (Dong, Zhou & Paul 2008)."""
