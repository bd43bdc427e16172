"""The node library of graphtex."""
