"""A wind turbine's planetary and two parallel stages, by mesh frequencies near those of the teeth, against equations of its own."""

from dataclasses import replace

import numpy as np
import pytest
from gearboxes import PLANETARY_TURBINE, train_of

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

BODIES = ["rotor", "carrier", "sun", "wheel 2", "pinion 2", "wheel 3", "pinion 3", "generator"]
BODIES += [f"stage 1 planet {number}" for number in (1, 2, 3)]
SHAFTS = (("rotor", "carrier"), ("sun", "wheel 2"), ("pinion 2", "wheel 3"), ("pinion 3", "generator"))


@pytest.fixture(scope="module")
def turbine():
    return train_of(PLANETARY_TURBINE)


class Turbine:
    """Equations by absolute angles of one sense of rotation, with the exact ratios of the teeth 21, 39, 99, 82/23 and 88/22."""

    def __init__(self, train):
        numbers = train.explain()
        place = {name: number for number, name in enumerate(BODIES)}
        self.inertia = np.array([numbers[name]["inertia"] for name in BODIES])
        carrier = 1 / ((1 + 99 / 21) * (82 / 23) * (88 / 22))  # turns per turn of the generator
        self.order = np.array([(1 + 99 / 21) * carrier * 82, 22, *6 * [99 * carrier]])
        self.torque = np.zeros(len(BODIES))
        self.torque[[place["rotor"], place["generator"]]] = 322e3, -322e3 * carrier
        rows, self.meshes = [], [numbers[f"mesh {number}"] for number in range(1, 9)]
        for (one, other), sense in zip(SHAFTS, (1, 1, -1, 1), strict=True):
            rows.append({one: sense, other: -sense})
        for number, mesh in enumerate(self.meshes):
            a, b = mesh["base_radius"]
            if number == 0:
                rows.append({"wheel 2": a, "pinion 2": b})
            elif number == 1:
                rows.append({"wheel 3": -a, "pinion 3": -b})
            elif number < 5:  # the ring drives the planets, and these the sun
                rows.append({"sun": -b, BODIES[8 + number - 2]: -a, "carrier": a + b})
            else:
                rows.append({BODIES[8 + number - 5]: b, "carrier": a - b})
        self.rows = np.zeros((len(rows), len(BODIES)))
        for row, entries in zip(self.rows, rows, strict=True):
            row[[place[name] for name in entries]] = list(entries.values())
        elements = [*(numbers[f"shaft {number}"] for number in range(1, 5)), *self.meshes]
        self.stiffness, self.damping = (np.array([part[name] for part in elements]) for name in ("stiffness", "damping"))
        self.half = np.array([mesh["half_backlash"] for mesh in self.meshes])
        self.kappa, self.error = self.harmonics("stiffness"), self.harmonics("error")

    def harmonics(self, name):
        """Of the harmonics 1 to 3 of each mesh, as factors of exp(i harmonic angle)."""
        cosine, sine = (np.array([np.append(mesh.get(f"{name}_{part}", 0.0), np.zeros(3))[:3] for mesh in self.meshes])
                        for part in ("cos", "sin"))
        return cosine - 1j * sine

    def fly(self, rpm, begin, length, samples):
        """Mesh displacements [m] from rest, at instants of the last part of a flight.

        Runge and Kutta's method of order 4 with equal steps, so that all excitations are known before the flight. With four steps
        a sample, an eighth of the period of the fastest mode, displacements are within 5e-5 of their range.
        """
        n, each = len(BODIES), 4
        step = length / (samples - 1) / each
        steps = round((begin + length) / step)
        columns, divided = self.rows.T, self.rows.T / self.inertia[:, None]
        # Excitations at the beginnings and the midpoints of the steps: errors, their damping forces over the inertias, stiffness.
        omega = self.order * rpm * 2 * np.pi / 60
        wave = np.exp(1j * np.outer(step / 2 * np.arange(2 * steps + 1), omega))
        wave = np.stack([wave, wave**2, wave**3])
        error = np.einsum("hkm,mh->km", wave, self.error).real
        rate = np.einsum("hkm,mh->km", wave, self.error * 1j * np.outer(omega, np.arange(1, 4))).real
        stiffness = self.stiffness[4:] * (1 + np.einsum("hkm,mh->km", wave, self.kappa).real)
        driven = np.zeros((len(error), 2 * n))
        driven[:, n:] = self.torque / self.inertia - (rate * self.damping[4:]) @ divided[:, 4:].T
        linear = np.zeros((2 * n, 2 * n))
        linear[:n, n:] = np.eye(n)
        linear[n:, :n] = -(divided[:, :4] * self.stiffness[:4]) @ columns[:, :4].T
        linear[n:, n:] = -(divided * self.damping) @ columns.T
        displacement = np.hstack([columns[:, 4:].T, np.zeros((len(self.meshes), n))])
        push = np.vstack([np.zeros((n, len(self.meshes))), -divided[:, 4:]])
        high, low = self.half, -self.half

        def rates(k, y):
            p = displacement @ y + error[k]
            return linear @ y + driven[k] + push @ (stiffness[k] * (p - np.minimum(np.maximum(p, low), high)))

        rest = np.linalg.lstsq(self.rows.T, self.torque, rcond=None)[0]
        twist = rest / self.stiffness
        twist[4:] += np.sign(rest[4:]) * self.half
        y = np.concatenate([np.linalg.lstsq(self.rows, twist, rcond=None)[0], np.zeros(n)])
        first, kept = steps - each * (samples - 1), []
        for k in range(steps + 1):
            if k >= first and (k - first) % each == 0:
                kept.append(displacement @ y + error[2 * k])
            if k < steps:
                one = rates(2 * k, y)
                two = rates(2 * k + 1, y + step / 2 * one)
                three = rates(2 * k + 1, y + step / 2 * two)
                y = y + step / 6 * (one + 2 * (two + three) + rates(2 * k + 2, y + step * three))
        return step * (first + each * np.arange(samples)), np.array(kept)


def test_mesh_frequencies_are_near_those_of_the_teeth(turbine):
    numbers = turbine.explain()
    orders = np.array([numbers[f"mesh {number}"]["order"] for number in range(1, 9)])
    assert orders.max() == 4817
    np.testing.assert_allclose(orders / numbers["train"]["speed_ratio"], Turbine(turbine).order, rtol=4.6e-6)


def test_a_coupling_leaves_the_nearby_mesh_frequencies(turbine):
    """A coupling has no order of its own."""
    coupled = replace(turbine, shafts=turbine.shafts[:3],
                      couplings=[gt.Coupling(between=("pinion 3", "generator"), stiffness=1e6, half_play=1e-3, damping_ratio=0.03)])
    assert coupled.explain()["train"]["speed_ratio"] == turbine.explain()["train"]["speed_ratio"]
    orders = [train.explain()[f"mesh {number}"]["order"] for number in range(1, 9) for train in (coupled, turbine)]
    assert orders[::2] == orders[1::2]


@pytest.mark.full
def test_its_response(turbine):
    branch = turbine.response(start=1100.0, stop=1900.0, unit="rpm", harmonics=0, tolerance=1e-3)
    assert branch.complete and branch.stable.all() and not branch.undecided.any() and branch.error_estimate.max() <= 1e-3
    largest = branch.mesh_force_maximum[:, 1].argmax()
    assert branch.speed[largest] == pytest.approx(1799, abs=1)
    assert branch.dynamic_factor[largest, 1] == pytest.approx(1.465, abs=2e-3)


@pytest.mark.parametrize(
    "rpm", [pytest.param(rpm, marks=pytest.mark.full if rpm == 1500 else pytest.mark.nightly) for rpm in (1130.0, 1500.0, 1799.0)])
def test_a_motion_is_that_of_the_exact_ratios(turbine, rpm):
    """Amplitudes of the strongest lines, at their exact frequencies, after 1.6 s from rest. The slowest mode, 2.84 Hz, rings on."""
    branch = turbine.response(start=rpm, stop=rpm + 1, unit="rpm", harmonics=0, tolerance=1e-3, stability=False, max_points=2)
    (motion,) = branch.at(rpm, unit="rpm")
    equations = Turbine(turbine)
    nearby = np.array([turbine.explain()[f"mesh {number}"]["order"] for number in (3, 1, 2)])
    exact = equations.order[[2, 0, 1]]
    # Sums of few mesh frequencies, the shortest first.
    sums = np.stack(np.meshgrid(*3 * [np.arange(-9, 10)]), axis=-1).reshape(-1, 3)
    frequency = {}
    for terms in sums[np.argsort(abs(sums).sum(axis=1), kind="stable")]:
        frequency.setdefault(terms @ nearby, terms @ exact)
    u = motion.coefficients
    strength = np.hypot(u[:, 1::2], u[:, 2::2]).max(axis=0)
    lines = []
    for harmonic in 1 + strength.argsort()[::-1][: np.count_nonzero(strength)]:
        f = frequency.get(harmonic, 0.0) * rpm / 60
        if len(lines) < 40 and f > 8 and all(abs(f - other) > 3 for _, other in lines):
            lines.append((harmonic, f))
    t, p = equations.fly(rpm, 1.6, 0.6, 4801)
    slow = 2 * np.pi * 2.83652 * t
    waves = [np.ones_like(t), np.cos(slow), np.sin(slow)]
    for _, f in lines:
        waves += [np.cos(2 * np.pi * f * t), np.sin(2 * np.pi * f * t)]
    fitted = np.linalg.lstsq(np.array(waves).T, p / turbine.explain()["train"]["characteristic_length"], rcond=None)[0]
    found = np.array([u[:, 2 * harmonic - 1 + part] for harmonic, _ in lines for part in (0, 1)])
    np.testing.assert_allclose(np.linalg.norm(found, axis=0), np.linalg.norm(fitted[3:], axis=0), rtol=1e-3)
    assert (np.linalg.norm(found - fitted[3:], axis=0) < 1e-2 * np.linalg.norm(found, axis=0)).all()
