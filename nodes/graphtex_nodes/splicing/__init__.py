"""Texture splicing (Liu et al. 2009): the elements of one texture in the arrangement of another."""
