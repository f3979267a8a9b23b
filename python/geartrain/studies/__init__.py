"""Many computations over a space of parameters."""
