"""Gearboxes with real tooth numbers, whose common period is long or whose idle gears rattle, and the equations of one of them
by SciPy."""

import tempfile
from pathlib import Path

import numpy as np

import geartrain as gt

#: Three stages of a wind turbine of 750 kW, a pair of gears in place of the planetary stage. The common period is 328 turns of the
#: generator, 483 cycles of the slowest mesh. The slowest mode, of the rotor against the generator, takes 130 s to fall to 1/e.
WIND_TURBINE = """
&train title = 'wind turbine gearbox', speed_of = 'generator' /
&body name = 'rotor', inertia = 1.0e6, torque = {torque} /
&body name = 'wheel 1' /
&body name = 'pinion 1' /
&body name = 'wheel 2' /
&body name = 'pinion 2' /
&body name = 'wheel 3' /
&body name = 'pinion 3' /
&body name = 'generator', inertia = 24.0, balances = .true. /
&shaft between = 'rotor', 'wheel 1', stiffness = 5.0e7, damping_ratio = 0.01 /
&mesh  between = 'wheel 1', 'pinion 1', teeth = 120, 21, normal_module = 10e-3, helix_angle = 7.5, face_width = 0.230,
       backlash = 300e-6, damping_ratio = 0.05, stiffness_harmonics = 3, error_cos = 8e-6 /
&shaft between = 'pinion 1', 'wheel 2', diameter = 0.180, length = 0.400, damping_ratio = 0.01 /
&mesh  between = 'wheel 2', 'pinion 2', teeth = 82, 23, normal_module = 8.25e-3, helix_angle = 14.0, face_width = 0.170,
       backlash = 250e-6, damping_ratio = 0.05, stiffness_harmonics = 3, error_cos = 6e-6 /
&shaft between = 'pinion 2', 'wheel 3', diameter = 0.120, length = 0.300, damping_ratio = 0.01 /
&mesh  between = 'wheel 3', 'pinion 3', teeth = 88, 22, normal_module = 5.0e-3, helix_angle = 14.0, face_width = 0.110,
       backlash = 200e-6, damping_ratio = 0.05, stiffness_harmonics = 3, error_cos = 4e-6 /
&shaft between = 'pinion 3', 'generator', diameter = 0.090, length = 0.400, damping_ratio = 0.01 /
"""

#: A twin-countershaft gearbox in its second gear: the engine, with the third order of its revolution, drives two equal
#: countershafts; each has three gears that mesh with three on the main shaft, of which the second is coupled to it and the others
#: turn without load.
TRUCK = """
&train title = 'twin-countershaft gearbox', speed_of = 'input' /
&body name = 'engine', inertia = 2.2, torque = 900.0, revolution_torque_cos = 0.0, 0.0, 400.0 /
&body name = 'input' /
&body name = 'counter 1' /
&body name = 'counter 2' /
&body name = 'gear 1', damping_to_ground = 0.02 /
&body name = 'gear 2', damping_to_ground = 0.02 /
&body name = 'gear 3', damping_to_ground = 0.02 /
&body name = 'vehicle', inertia = 60.0, balances = .true. /
&shaft between = 'engine', 'input', stiffness = 2.0e4, damping_ratio = 0.02 /
""" + "".join(
    f"&mesh between = '{driver}', '{driven}', teeth = {a}, {b}, normal_module = 4e-3, face_width = 0.04, backlash = 150e-6,\n"
    f"      damping_ratio = 0.05, damping_acts = 'contact', stiffness_harmonics = 3, error_cos = 5e-6 /\n"
    for driver, driven, a, b in (
        ("input", "counter 1", 23, 40), ("input", "counter 2", 23, 40),
        ("counter 1", "gear 1", 17, 47), ("counter 2", "gear 1", 17, 47),
        ("counter 1", "gear 2", 26, 38), ("counter 2", "gear 2", 26, 38),
        ("counter 1", "gear 3", 33, 31), ("counter 2", "gear 3", 33, 31),
    )
) + "&shaft between = 'gear 2', 'vehicle', stiffness = 5.0e4, damping_ratio = 0.02 /\n"

#: The NREL 5 MW reference gearbox (A. R. Nejad, Y. Guo, Z. Gao, T. Moan, Wind Energy 19 (2016) 1089-1106): pairs of gears of the
#: planetary stages' teeth in place of the planets. Backlash, damping and errors are assumed.
REFERENCE_TURBINE = """
&train title = 'NREL 5 MW reference gearbox, pairs for planets', speed_of = 'generator' /
&body name = 'rotor', inertia = 5.7231535e7, torque = 3946000.0 /
&body name = 'wheel 1' /
&body name = 'pinion 1' /
&body name = 'wheel 2' /
&body name = 'pinion 2' /
&body name = 'wheel 3' /
&body name = 'pinion 3' /
&body name = 'generator', inertia = 534.116, balances = .true. /
&shaft between = 'rotor', 'wheel 1', stiffness = 8.67637e8, damping_ratio = 0.01 /
&mesh between = 'wheel 1', 'pinion 1', teeth = 75, 19, normal_module = 45e-3, face_width = 1.473, profile_shift = 0.0, 0.617,
      bore = 2.6, 0.4, backlash = 900e-6, damping_ratio = 0.05, error_cos = 15e-6 /
&shaft between = 'pinion 1', 'wheel 2', diameter = 0.533, length = 1.250, damping_ratio = 0.01 /
&mesh between = 'wheel 2', 'pinion 2', teeth = 111, 18, normal_module = 21e-3, face_width = 1.650, profile_shift = 0.0, 0.389,
      bore = 1.9, 0.2, backlash = 500e-6, damping_ratio = 0.05, error_cos = 10e-6 /
&shaft between = 'pinion 2', 'wheel 3', diameter = 0.333, length = 0.850, damping_ratio = 0.01 /
&mesh between = 'wheel 3', 'pinion 3', teeth = 95, 24, normal_module = 14e-3, helix_angle = 10.0, face_width = 0.360,
      profile_shift = 0.669, 0.480, centre_distance = 0.861, bore = 0.5, 0.2, backlash = 350e-6,
      damping_ratio = 0.05, error_cos = 6e-6 /
&shaft between = 'pinion 3', 'generator', diameter = 0.190, length = 1.0, damping_ratio = 0.01 /
"""

#: Reverse gear of the five-speed transaxle RS5F32V (teeth 14, 37, 45, 17, 71 by its service manual). The rest is assumed.
TRANSAXLE = """
&train title = 'car transaxle in reverse', speed_of = 'engine' /
&body name = 'engine', inertia = 0.18, torque = 160.0 /
&body name = 'input' /
&body name = 'idler' /
&body name = 'main' /
&body name = 'pinion' /
&body name = 'ring' /
&body name = 'vehicle', inertia = 110.0, balances = .true. /
&shaft between = 'engine', 'input', stiffness = 1100.0, damping_ratio = 0.05 /
&mesh between = 'input', 'idler', teeth = 14, 37, normal_module = 2.5e-3, face_width = 0.016, backlash = 150e-6,
      profile_shift = 0.3, 0.0, bore = 0.0, 0.025, damping_ratio = 0.05, error_cos = 6e-6 /
&mesh between = 'idler', 'main', teeth = 37, 45, normal_module = 2.5e-3, face_width = 0.016, backlash = 150e-6, bore = 0.025, 0.04,
      damping_ratio = 0.05, error_cos = 6e-6 /
&shaft between = 'main', 'pinion', diameter = 0.034, length = 0.120, damping_ratio = 0.01 /
&mesh between = 'pinion', 'ring', teeth = 17, 71, normal_module = 2.25e-3, helix_angle = 28.0, face_width = 0.030,
      backlash = 110e-6, damping_ratio = 0.05, error_cos = 3e-6 /
&shaft between = 'ring', 'vehicle', stiffness = 9000.0, damping_ratio = 0.02 /
"""

#: The turbine of ``namelists/wind_turbine.nml`` with its planetary stage, without analyses.
PLANETARY_TURBINE = (Path(__file__).resolve().parents[2] / "namelists" / "wind_turbine.nml").read_text().split("&modes")[0]


def train_of(text):
    """The train of a case."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.nml"
        path.write_text(text + "&modes /\n")
        return gt.read_case(path).train


def wind_turbine(torque=322e3):
    return train_of(WIND_TURBINE.format(torque=torque))


def truck():
    return train_of(TRUCK)


class Chain:
    """The equations of motion of bodies in a row, shaft, mesh, shaft, ..., by the angles of all bodies, from `Train.explain`."""

    def __init__(self, train, speed, *, rate=0.0):
        """``speed`` in rpm, which changes by ``rate`` rpm/s."""
        numbers = train.explain()
        bodies = [body.name for body in train.bodies]
        self.inertia = np.array([numbers[name]["inertia"] for name in bodies])
        turns = np.abs([numbers[name]["turns"] for name in bodies])
        self.meshes = [numbers[f"mesh {place}"] for place in range(1, len(train.meshes) + 1)]
        self.places = np.arange(1, len(bodies) - 1, 2)
        shafts = [numbers[f"shaft {place}"] for place in range(1, len(train.shafts) + 1)]
        self.rows = np.zeros((len(bodies) - 1, len(bodies)))
        self.stiffness, ratio = np.zeros(len(self.rows)), np.zeros(len(self.rows))
        for place in range(len(self.rows)):
            part = self.meshes[place // 2] if place % 2 else shafts[place // 2]
            described = (train.meshes if place % 2 else train.shafts)[place // 2]
            radii = part["base_radius"] if place % 2 else (1.0, 1.0)
            self.rows[place, place : place + 2] = radii[0], -radii[1]
            self.stiffness[place], ratio[place] = part["stiffness"], described.damping_ratio
        self.damping = 2 * ratio * np.sqrt(self.stiffness / (self.rows**2 / self.inertia).sum(axis=1))
        self.half = np.array([mesh["half_backlash"] for mesh in self.meshes])
        self.order = np.array([mesh["order"] for mesh in self.meshes])
        self.kappa = np.array([mesh["stiffness_cos"] for mesh in self.meshes])
        self.harmonics = np.outer(self.order, np.arange(1, self.kappa.shape[1] + 1))
        self.error = np.array([mesh.error_cos[0] for mesh in train.meshes])
        ratio_of_speed = numbers["train"]["speed_ratio"]
        self.omega, self.ramp = 2 * np.pi / 60 / ratio_of_speed * np.array([speed, rate])
        alpha = 2 * np.pi / 60 * rate * turns / turns[-1]
        # Each body's mean torque, less what accelerates it; the last body takes what remains.
        self.torque = np.zeros(len(bodies))
        self.torque[0] = train.bodies[0].torque
        steady = self.torque - self.inertia * alpha
        steady[-1] = -(steady[:-1] * turns[:-1]).sum() / turns[-1]
        self.torque = steady
        self.unit = numbers["train"]["characteristic_length"]
        self.frequency = numbers["train"]["characteristic_frequency"]
        # Forces at rest at constant speed, from which the twists of shafts in a state are measured.
        self.static = np.zeros(len(self.rows))
        load = train.bodies[0].torque
        for place in range(len(self.rows)):
            self.static[place] = load / self.rows[place, place]
            load = -self.static[place] * self.rows[place, place + 1]
        # A shaft's twist is measured along the base circle of the gear that follows, of the last one that comes before.
        self.radius = np.ones(len(self.rows))
        self.radius[:-1:2] = [self.rows[place, place] for place in self.places]
        self.radius[-1] = -self.rows[-2, -2]

    def phase(self, t):
        return self.omega * t + self.ramp * t**2 / 2, self.omega + self.ramp * t

    def displacements(self, t, y):
        n = len(self.inertia)
        p, v = self.rows @ y[:n], self.rows @ y[n:]
        angle, rate = self.phase(t)
        p[self.places] += self.error * np.cos(self.order * angle)
        v[self.places] -= self.error * self.order * rate * np.sin(self.order * angle)
        return p, v

    def forces(self, t, y):
        """Displacements and forces of all elements."""
        p, v = self.displacements(t, y)
        angle = self.phase(t)[0]
        force = self.stiffness * p + self.damping * v
        place = self.places
        kappa = 1 + (self.kappa * np.cos(self.harmonics * angle)).sum(axis=1)
        gap = p[place] - np.minimum(np.maximum(p[place], -self.half), self.half)
        force[place] = self.stiffness[place] * kappa * gap + self.damping[place] * v[place]
        return p, force

    def fly_motion(self, motion):
        """A motion at the instants of its waveform, from its state."""
        return self.fly(motion.state, motion.time / self.frequency)

    def fly(self, state, time):
        """Mesh displacements over the characteristic length, mesh forces and torques of shafts at instants, from a state."""
        from scipy.integrate import solve_ivp  # which programs that the tests start have no use for

        n = len(self.inertia)
        y = np.zeros(2 * n)
        p0, v0 = self.displacements(0.0, y)
        rest = np.where(np.arange(len(self.rows)) % 2 == 0, self.static / self.stiffness, 0.0)
        for place, (row, radius) in enumerate(zip(self.rows, self.radius, strict=True)):
            moved = state[place] * self.unit / radius - p0[place] + rest[place]
            speed = state[len(self.rows) + place] * self.unit * self.frequency / radius - v0[place]
            y[place + 1] = (row[place] * y[place] - moved) / -row[place + 1]
            y[n + place + 1] = (row[place] * y[n + place] - speed) / -row[place + 1]

        def rates(t, y):
            return np.concatenate([y[n:], (self.torque - self.rows.T @ self.forces(t, y)[1]) / self.inertia])

        found = solve_ivp(rates, (0, time[-1]), y, method="DOP853", rtol=1e-7, atol=1e-11, t_eval=time)
        p, force = np.array([self.forces(t, y) for t, y in zip(time, found.y.T, strict=True)]).swapaxes(0, 1)
        return p[:, self.places] / self.unit, force[:, self.places], force[:, ::2]
