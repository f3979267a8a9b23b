"""The dynamic factor K_v of ISO 6336-1:2006, method B, to stand beside a computed one."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Pair", "dynamic_factor"]


@dataclass(frozen=True)
class Pair:
    """A gear pair.

    Attributes
    ----------
    teeth : int
        Of the driving gear.
    radii : (float, float)
        Base circles [m].
    inertias : (float, float)
        Of the gears [kg m^2].
    width : float
        Face width [m].
    contact_ratio : float
        Total contact ratio.
    single, mesh : float
        c' and c_gamma_alpha [N/m^2].
    line_load : float
        F_t K_A/b [N/m].
    base_pitch, profile : float
        Effective deviations of base pitch and profile [m].
    """

    teeth: int
    radii: tuple[float, float]
    inertias: tuple[float, float]
    width: float
    contact_ratio: float
    single: float
    mesh: float
    line_load: float
    base_pitch: float
    profile: float

    @property
    def resonance(self) -> float:
        """Speed of the driving gear at the main resonance, n_E1 [rpm]."""
        one, other = self.inertias
        mass = one * other / (one * self.radii[1] ** 2 + other * self.radii[0] ** 2)
        return 30 / (math.pi * self.teeth) * math.sqrt(self.mesh * self.width / mass)


def dynamic_factor(pair: Pair, speed: float) -> tuple[float, float]:
    """K_v without tip relief, and the resonance ratio N, at a speed of the driving gear [rpm]."""
    ratio = abs(speed) / pair.resonance
    pitch, profile = (pair.single * of / pair.line_load for of in (pair.base_pitch, pair.profile))  # B_p and B_f; B_k is 1
    total = pair.contact_ratio
    c1, c5 = 0.32, 0.47
    if total <= 2:
        c2, c3, c4, c6 = 0.34, 0.23, 0.90, 0.47
    else:
        c2, c3 = 0.57 / (total - 0.3), 0.096 / (total - 1.56)
        c4, c6 = (0.57 - 0.05 * total) / (total - 1.44), 0.12 / (total - 1.74)
    c7 = 0.75 if total <= 1.5 else 0.125 * math.sin(math.pi * (total - 2)) + 0.875 if total <= 2.5 else 1.0
    begins = 0.85 if pair.line_load >= 1e5 else 0.5 + 0.35 * math.sqrt(pair.line_load / 1e5)
    main, above = c1 * pitch + c2 * profile + c4 + 1, c5 * pitch + c6 * profile + c7
    if ratio <= begins:
        return ratio * (c1 * pitch + c2 * profile + c3) + 1, ratio
    if ratio <= 1.15:
        return main, ratio
    if ratio < 1.5:
        return above + (main - above) * (1.5 - ratio) / 0.35, ratio
    return above, ratio
