"""jaxcont: figure 3 by sampled harmonic balance, the residual ours, the Jacobian by jax, the continuation compiled as a whole."""

from importlib.metadata import version

import jax
import jax.numpy as jnp
import numpy as np
from jaxcont.core.scan_continuation import pseudo_arclength_scan

from figure3 import DAMPING, KAPPA, LOAD, MASS, MESHES, REST, START, STOP, arguments, repeated, report, rms

jax.config.update("jax_enable_x64", True)


def make_residual(harmonics, samples):
    """f(u, Lambda) with u (1 + 2R, 5) flattened: mean, cos 1, sin 1, ... of every element."""
    phase = 2 * np.pi * np.arange(samples) / samples
    order = np.arange(1, harmonics + 1)
    waves = np.ones((samples, 1 + 2 * harmonics))
    waves[:, 1::2], waves[:, 2::2] = np.cos(np.outer(phase, order)), np.sin(np.outer(phase, order))
    project = 2 * waves.T / samples
    project[0] /= 2
    derivative = np.zeros((1 + 2 * harmonics,) * 2)  # of the coefficients with respect to Lambda t
    derivative[2 * order - 1, 2 * order], derivative[2 * order, 2 * order - 1] = order, -order
    twice = derivative @ derivative
    kappa = (1 + KAPPA * np.cos(phase))[:, None]

    def residual(u, frequency):
        p = u.reshape(-1, len(LOAD))
        time = waves @ p[:, MESHES]
        elastic = p.at[:, MESHES].set(project @ (kappa * (time - jnp.clip(time, -1, 1))))
        inertia = frequency**2 * twice @ p @ MASS.T
        return (inertia + frequency * derivative @ p * DAMPING + elastic).at[0].add(-LOAD).ravel()

    return residual


def main():
    options = arguments(harmonics=6, samples=128, step=0.05)
    residual = make_residual(options.harmonics, options.samples)

    def newton(_, u):
        return u - jnp.linalg.solve(jax.jacfwd(residual)(u, START), residual(u, START))

    rest = jnp.zeros((1 + 2 * options.harmonics, len(LOAD))).at[0].set(REST).ravel()
    first = jax.lax.fori_loop(0, 20, newton, rest)

    def curve():
        found = pseudo_arclength_scan(residual, first, START, STOP, 1e-3, 1e-7, options.step, 1e-8, 4000, 12)
        return jax.block_until_ready(found)

    first_time, seconds, found = repeated(curve, options.repeats)
    points = int(found.n_valid)
    report(
        options.output, tool=f"jaxcont {version('jaxcont')} (jax {jax.__version__})", first=first_time,
        seconds=seconds, frequency=np.array(found.params[:points]), stable=None,
        rms=rms(np.array(found.states[:points]).reshape(points, -1, len(LOAD))),
    )  # fmt: skip


if __name__ == "__main__":
    main()
