"""Comparisons of results of a train and of its image.

A tolerance is the error of a method times a margin: Newton's method ends at a relative change of 1e-10 or better, of which a motion
near a fold keeps fewer digits; shooting ends at about 1e-11; integration settles to 1e-9 per period, and a motion whose
multiplier is 0.99 is then 1e-7 away.
"""

import numpy as np

#: Motions by the balance and their multipliers; motions by shooting; motions that integration settles on [1].
BALANCE, SHOOTING, SETTLED = 1e-7, 1e-8, 1e-5
#: Special points of the balance, but for the error of the multipliers; places on a curve, by interpolation of its points [1].
PLACE, CURVE = 1e-8, 1e-4
#: Multipliers of a motion of the balance: a period is some hundred exponentials, each to 5e-10 [1].
MULTIPLIER = 1e-7


def close(found, expected, tolerance, what, scale=None):
    """Check values to a tolerance relative to the largest of the expected ones, or to a scale."""
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    assert found.shape == expected.shape, f"{what}: shapes {found.shape}, {expected.shape}"
    assert (np.isnan(found) == np.isnan(expected)).all(), f"{what}: {found}, {expected}"
    scale = np.nanmax(np.abs(expected), initial=0.0) if scale is None else scale
    worst = np.nanmax(np.abs(found - expected) / np.maximum(scale, 1e-300), initial=0.0)
    assert worst <= tolerance, f"{what}: {found}, expected {expected}, off by {worst:.2g}"


def same_motion(found, known, image, tolerance, what):
    """Check the figures of a motion of the image; displacements relative to the largest of their mesh, forces likewise."""
    sign = -1 if image.mirrored else 1
    low, high = ("maximum", "minimum") if image.mirrored else ("minimum", "maximum")
    scale = np.maximum(np.abs(known.minimum), np.abs(known.maximum))[image.meshes] * image.displacement
    for name, other, factor in (("rms", "rms", 1), ("mean", "mean", sign), ("minimum", low, sign), ("maximum", high, sign)):
        wanted = factor * getattr(known, other)[image.meshes] * image.displacement
        close(getattr(found, name), wanted, tolerance, f"{what} {name}", scale)
    force = known.mesh_force_maximum[image.meshes] * image.force
    close(found.mesh_force_maximum, force, tolerance, f"{what} force", np.abs(force).max())
    # A share of the period changes like the square root of a displacement where a mesh grazes the edge of its gap.
    shares = [known.separation_fraction[image.meshes], known.back_contact_fraction[image.meshes]]
    if image.mirrored:
        gap = np.array([(mesh.half_backlash or 0) > 0 for mesh in image.train.meshes])
        shares[1] = np.where(gap, 1 - shares[0] - shares[1], 0.0)
    close(found.separation_fraction, shares[0], tolerance**0.5, f"{what} separation", 1.0)
    close(found.back_contact_fraction, shares[1], tolerance**0.5, f"{what} back contact", 1.0)
    if known.shaft_torque_mean is None or not len(known.shaft_torque_mean):
        return
    old = image.shafts >= 0
    places, factor = image.shafts[old], image.torque[old]
    ends = np.sort([known.shaft_torque_minimum[places] * factor, known.shaft_torque_maximum[places] * factor], axis=0)
    scale = np.abs(ends).max(initial=0.0)
    close(found.shaft_torque_mean[old], known.shaft_torque_mean[places] * factor, tolerance, f"{what} torque", scale)
    close([found.shaft_torque_minimum[old], found.shaft_torque_maximum[old]], ends, tolerance, f"{what} torques", scale)


def same_waveform(found, known, image, tolerance, what):
    """Check the amplitudes, which a later beginning of time turns; harmonics that the original lacks are none."""
    factor, period = image.cycles * image.subharmonic, known.period or 1
    count = (known.coefficients.shape[1] - 1) // 2
    amplitude = (known.coefficients[:, 1::2] - 1j * known.coefficients[:, 2::2])[image.meshes]
    amplitude = amplitude * np.exp(-1j * image.phase * np.arange(1, count + 1) / period) * image.displacement[:, None]
    wanted = np.zeros((len(image.meshes), count * factor), complex)
    wanted[:, factor - 1 :: factor] = -amplitude if image.mirrored else amplitude
    have = found.coefficients[:, 1::2] - 1j * found.coefficients[:, 2::2]
    scale = np.maximum(np.abs(known.minimum), np.abs(known.maximum))[image.meshes, None] * image.displacement[:, None]
    assert have.shape == wanted.shape, f"{what}: harmonics {have.shape}, {wanted.shape}"
    close(np.abs(have - wanted), np.zeros(have.shape), tolerance, f"{what} amplitudes", scale)


def same_multipliers(found, known, image, tolerance, what):
    """Check the largest multiplier and the verdict. A motion of as many periods has the power of a multiplier.

    A double multiplier is known to the square root of the rounding of the matrix.
    """
    power = image.cycles * image.subharmonic
    largest = np.abs(known.multipliers).max() ** power
    close(np.abs(found.multipliers).max(), largest, power * tolerance**0.5, f"{what} multiplier", max(largest, 1e-3))
    if not (found.undecided or known.undecided):
        assert bool(found.stable) == bool(known.stable), f"{what}: stable {found.stable}, {known.stable}"


def points_of(branch, image):
    """The special points of a branch; of motions seen as those of a longer period the folds alone, as doublings are none there."""
    return [point for point in branch.special_points if image.subharmonic == 1 or point.kind == "fold"]


def place_of(point):
    """Lambda, or the value of the parameter of its branch."""
    return point.frequency if point.parameter is None else point.parameter


def uncertainty(point):
    """Error of the place of a special point: of a change of stability that of a multiplier over its slope."""
    error = PLACE * place_of(point)
    if point.kind == "fold":
        return error
    branch, two = point.branch, slice(point.point, point.point + 2)
    sizes = np.sort(np.abs(branch.multipliers[two]), axis=1)
    slopes = np.abs(np.diff(sizes, axis=0)[0])[np.prod(sizes - 1, axis=0) < 0]
    way = np.ptp((branch.frequency if branch.parameter is None else branch.parameter)[two])
    return error + MULTIPLIER * way / max(slopes.min(initial=1.0), MULTIPLIER)


def same_points(known, found, image, tolerance=None):
    """Check kinds and places of the special points that are decided; a tolerance is relative, else each has its own."""
    points = [points_of(branch, image) for branch in (known, found)]
    if any(point.undecided for side in points for point in side):
        return
    kinds = [[point.kind for point in side] for side in points]
    places = [np.array([place_of(point) for point in side]) for side in points]
    assert kinds[0] == kinds[1], f"special points {kinds} at {places}"
    wanted = places[0] * (image.frequency if known.parameter is None else 1.0)
    errors = np.array([uncertainty(point) for point in points[0]]) / np.maximum(places[0], 1e-300) * wanted
    close(places[1], wanted, tolerance or 1.0, "special points", np.abs(wanted) if tolerance else errors)


def same_flow(found, known, image, what):
    """Check a motion that integration gave. Of what does not repeat itself the kind alone is compared, and where it is decided."""
    decided = ("periodic", "chaotic", "quasi-periodic", "unbounded")
    if known.kind in decided and found.kind in decided:
        assert known.kind == found.kind, f"{what}: {found.kind}, {known.kind}"
    if known.kind == found.kind == "periodic":
        period = known.period // np.gcd(known.period, image.cycles)
        assert found.period == period, f"{what}: period {found.period}, {period}"
        same_motion(found, known, image, SETTLED, what)


def same_sections(found, known, image, what):
    """Check sections and exponents of a flow; of one that does not repeat itself within the uncertainties."""
    decided = ("periodic", "chaotic", "quasi-periodic", "unbounded")
    if not (known.kind in decided and found.kind in decided):
        return
    assert known.kind == found.kind, f"{what}: {found.kind}, {known.kind}"
    if known.kind == "unbounded":
        return
    factor = image.frequency * image.cycles
    if known.kind != "periodic":
        uncertain = known.errors[0] * factor + found.errors[0]
        close(found.exponents[0], known.exponents[0] * factor, 2.0, f"{what} exponents", uncertain)
        return
    assert found.period == known.period // np.gcd(known.period, image.cycles), f"{what}: period {found.period}, {known.period}"
    # The growth of a vector differs from that of its mode by less than the axes of the ellipses on which sections spiral, of a
    # ratio below 100 for trains damped so little.
    spans = [len(side.displacement) * 2 * np.pi / side.frequency for side in (known, found)]
    uncertain = np.log(100) * (factor / spans[0] + 1 / spans[1])
    close(found.exponents[:1], known.exponents[:1] * factor, uncertain, f"{what} exponent", 1.0)
    if not image.phase and image.cycles == 1:
        wanted = known.displacement[-1, image.meshes] * image.displacement * (-1 if image.mirrored else 1)
        there = np.isfinite(wanted) & np.isfinite(found.displacement[-1])
        close(found.displacement[-1][there], wanted[there], 1e-4, f"{what} section", np.abs(known.displacement[:, image.meshes]
              * image.displacement).max(axis=0)[there] + image.displacement[there] * 1e-3)
