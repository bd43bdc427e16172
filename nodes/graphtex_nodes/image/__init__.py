"""Pictures in and out, exemplars that nodes generate, and conversions."""
