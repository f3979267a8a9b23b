"""Torque of a single cylinder from a pressure that was measured over a cycle of four strokes."""

import numpy as np

# Pressure in the cylinder [bar] at every third degree of the crank from firing top dead centre on, and bore, stroke, rod [m]: an
# engine at 1000 rpm, every thirtieth value of Experimental.csv (0.1 degrees) of A. Ballerini, "Post-process of experimental
# in-cylinder pressure curves to obtain heat release rate curves", github.com/AlbertoBallerini/PDL_Alberto_Ballerini, 2023.
BORE, STROKE, ROD = 0.085, 0.088, 0.141
PRESSURE = np.array([float(word) for word in """
    40.97 42.55 43.75 44.61 44.96 44.42 42.86 40.44 37.48 34.24 31 27.87 24.96 22.32 19.95 17.88 16.05 14.45 13.07 11.86
    10.81 9.89 9.07 8.36 7.74 7.18 6.68 6.26 5.88 5.53 5.22 4.94 4.7 4.47 4.27 4.09 3.93 3.78 3.65 3.52 3.41 3.31 3.21 3.13
    3.07 2.99 2.93 2.86 2.77 2.67 2.55 2.4 2.23 2.05 1.86 1.64 1.42 1.2 1.03 0.87 0.78 0.71 0.68 0.7 0.74 0.79 0.84 0.88 0.92
    0.94 0.93 0.91 0.88 0.85 0.8 0.76 0.75 0.73 0.76 0.77 0.81 0.84 0.87 0.89 0.9 0.88 0.87 0.83 0.81 0.8 0.8 0.81 0.82 0.85
    0.88 0.9 0.91 0.91 0.89 0.87 0.85 0.84 0.85 0.87 0.91 0.92 0.93 0.93 0.92 0.91 0.9 0.91 0.93 0.97 1.01 1.06 1.11 1.16
    1.14 1.08 0.97 0.87 0.87 0.89 0.87 0.89 0.88 0.87 0.89 0.88 0.88 0.88 0.88 0.89 0.89 0.89 0.89 0.9 0.92 0.91 0.91 0.91
    0.91 0.91 0.92 0.93 0.92 0.92 0.92 0.92 0.92 0.92 0.92 0.92 0.92 0.92 0.93 0.93 0.93 0.94 0.94 0.94 0.94 0.95 0.96 0.96
    0.96 0.97 0.96 0.97 0.97 0.97 0.96 0.98 0.98 0.99 0.99 0.98 0.99 0.98 0.98 1 0.99 1 1.01 1.01 1.03 1.03 1.04 1.06 1.07
    1.09 1.11 1.12 1.14 1.17 1.2 1.24 1.27 1.3 1.33 1.38 1.43 1.48 1.53 1.6 1.66 1.74 1.83 1.91 2.01 2.13 2.27 2.41 2.57 2.76
    2.97 3.2 3.46 3.78 4.13 4.54 5.02 5.57 6.22 6.99 7.88 8.93 10.18 11.66 13.38 15.42 17.79 20.49 23.49 26.72 30.05 33.32
    36.34 38.9
""".split()])
ANGLES = 4 * np.pi * np.arange(len(PRESSURE)) / len(PRESSURE)


def gas_torque():
    """Torque of the gas on the crank [N m] at the angles of the measurement, by the arm of the piston's force."""
    crank = STROKE / 2
    arm = crank * np.sin(ANGLES) * (1 + crank * np.cos(ANGLES) / np.sqrt(ROD**2 - (crank * np.sin(ANGLES)) ** 2))
    return (PRESSURE - 1.0) * 1e5 * np.pi / 4 * BORE**2 * arm
