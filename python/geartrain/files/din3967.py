"""Tooth thickness allowances of DIN 3967:1978: what a word as 'c25' says of the backlash."""

from __future__ import annotations

import re
from bisect import bisect_left

__all__ = ["mean_thinning"]

#: Upper ends of the ranges of reference diameters [m].
_DIAMETERS = (0.010, 0.050, 0.125, 0.280, 0.560, 1.0, 1.6, 2.5)

#: Upper allowance of the tooth thickness in the normal section, reversed in sign [um], by series and range of diameters.
_ALLOWANCES = {
    "a": (100, 135, 180, 250, 330, 450, 600, 820),
    "ab": (85, 110, 150, 200, 280, 370, 500, 680),
    "b": (70, 95, 125, 170, 230, 310, 420, 560),
    "bc": (58, 75, 105, 140, 190, 260, 340, 460),
    "c": (48, 65, 85, 115, 155, 210, 290, 390),
    "cd": (40, 54, 70, 95, 130, 175, 240, 320),
    "d": (33, 44, 60, 80, 110, 145, 200, 270),
    "e": (22, 30, 40, 56, 75, 100, 135, 180),
    "f": (10, 14, 19, 26, 35, 48, 64, 85),
    "g": (5, 7, 9, 12, 17, 22, 30, 41),
    "h": (0, 0, 0, 0, 0, 0, 0, 0),
}

#: Tolerance of the tooth thickness [um] by range of diameters, series 21 to 30.
_TOLERANCES = (
    (3, 5, 8, 12, 20, 30, 50, 80, 130, 200),
    (5, 8, 12, 20, 30, 50, 80, 130, 200, 300),
    (6, 10, 16, 25, 40, 60, 100, 160, 250, 400),
    (8, 12, 20, 30, 50, 80, 130, 200, 300, 500),
    (10, 16, 25, 40, 60, 100, 160, 250, 400, 600),
    (12, 20, 30, 50, 80, 130, 200, 300, 500, 800),
    (16, 25, 40, 60, 100, 160, 250, 400, 600, 1000),
    (20, 30, 50, 80, 130, 200, 300, 500, 800, 1300),
)


def mean_thinning(series: str, diameter: float) -> float | None:
    """Mean of the upper and the lower allowance of the normal tooth thickness, reversed in sign [m].

    Parameters
    ----------
    series : str
        As ``'c25'``.
    diameter : float
        Reference diameter [m].

    Returns
    -------
    float or None
        None where the word or the diameter is outside the tables.
    """
    found = re.fullmatch(r"\s*([a-h]{1,2})\s*(2\d|30)\s*", series)
    place = bisect_left(_DIAMETERS, diameter)
    if found is None or found[1] not in _ALLOWANCES or found[2] == "20" or place == len(_DIAMETERS):
        return None
    return 1e-6 * (_ALLOWANCES[found[1]][place] + _TOLERANCES[place][int(found[2]) - 21] / 2)
