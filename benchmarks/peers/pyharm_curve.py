"""pyHarm: figure 3 by sampled harmonic balance, with an element class of our own for the meshes."""

import logging
from importlib.metadata import version

import numpy as np
from pyHarm.Elements.SubstructureMatrixElements.MatrixElement import MatrixElement
from pyHarm.Maestro import Maestro

from figure3 import DAMPING, KAPPA, LOAD, MASS, MESHES, REST, START, STOP, arguments, repeated, report, rms


class MeshForces(MatrixElement):
    """(1 + 0.3 cos) g(p) of both meshes by the DFT of samples, less the static load of all elements."""

    factory_keyword = "mesh_forces"

    def _generateMatrices(self, data):
        samples = self.D["ft"].shape[1]
        self.kappa = 1 + KAPPA * np.cos(2 * np.pi * np.arange(samples) / samples)

    def __flag_update__(self):
        self.flag_nonlinear = True
        self.flag_AFT = True

    def adim(self, lc, wc):
        raise NotImplementedError("the equations are dimensionless as they are")

    def evalResidual(self, xg, om):
        p = xg[self.indices].reshape(-1, len(LOAD))
        time = self.D["ft"].T @ p[:, MESHES]
        force = np.zeros_like(p)
        force[0] = -LOAD
        force[:, MESHES] += self.D["tf"].T @ (self.kappa[:, None] * (time - np.clip(time, -1, 1)))
        return force.ravel()

    def evalJacobian(self, xg, om):
        p = xg[self.indices].reshape(-1, len(LOAD))
        blocks, size = p.shape
        jacobian = np.zeros((blocks, size, blocks, size))
        for mesh in MESHES:
            slope = self.kappa * (np.abs(self.D["ft"].T @ p[:, mesh]) > 1)
            jacobian[:, mesh, :, mesh] = (self.D["tf"].T * slope) @ self.D["ft"].T
        return jacobian.reshape(blocks * size, -1), np.zeros(blocks * size)


def curve(options):
    stiffness = np.diag(~np.isin(np.arange(len(LOAD)), MESHES) * 1.0)
    start = np.zeros((1 + 2 * options.harmonics, len(LOAD)))
    start[0] = REST
    maestro = Maestro({
        "plugin": [MeshForces],
        "system": {"type": "Base", "nh": options.harmonics, "nti": options.samples},
        "substructures": {"train": {"matrix": {"M": MASS, "C": np.diag(DAMPING), "K": stiffness}, "ndofs": 1}},
        "connectors": {"meshes": {"type": "mesh_forces", "connect": "train"}},
        "analysis": {"curve": {
            "study": "frf", "solver": "NewtonRaphson", "solver_options": {"max_iter": 12}, "predictor": "tangent",
            "corrector": "pseudo_arc_length", "puls_inf": START, "puls_sup": STOP, "puls_start": START,
            "ds0": 1e-3, "ds_min": 1e-7, "ds_max": options.step, "verbose": False,
        }},
    })  # fmt: skip
    maestro.operate(start.ravel())
    return [solution.x for solution in maestro.nls["curve"].SolList if solution.flag_accepted]


def main():
    options = arguments(harmonics=6, samples=128, step=0.05)
    logging.disable()
    first, seconds, found = repeated(lambda: curve(options), options.repeats)
    found = np.array(found)
    report(
        options.output, tool=f"pyHarm {version('pyharm-os')}", first=first, seconds=seconds, frequency=found[:, -1],
        rms=rms(found[:, :-1].reshape(len(found), -1, len(LOAD))), stable=None,
    )  # fmt: skip


if __name__ == "__main__":
    main()
