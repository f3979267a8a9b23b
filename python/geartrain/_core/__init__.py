"""What all parts of the package use: the border to Fortran, units, tables, messages."""
