"""Exemplars that nodes generate: materials drawn on a plane, with their true scale, and the named samples."""
