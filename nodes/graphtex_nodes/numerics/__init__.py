"""Pure array functions that several nodes share."""
