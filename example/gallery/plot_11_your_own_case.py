"""
Is it right? Your own case
==========================

Four questions that you can ask of any case. Shooting checks harmonic balance: both methods share the model and the mesh law, but
not the transform, the stability analysis or the error estimate.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml").train
branch = train.response(start=0.2, stop=2.6, harmonics=12)

# %%
# **Is it the train that I meant?** ``explain`` lists every number, given or derived; ``modes`` lists the natural frequencies.

print(train.explain()["mesh 1"])
print(train.modes())

# %%
# **Are the points and their stability right?** The audit solves random points, all folds and all changes of stability again by
# shooting. In a shell: ``geartrain --audit CASE.nml``.

audit = branch.audit(points=20)
print(audit)
assert audit.ok

# %%
# **Are there enough harmonics?** Each point has an error estimate; ``harmonics=0`` with a ``tolerance`` chooses the harmonics.
# The picture compares the estimate with the true error, the distance to the orbit that shooting finds (to about 1e-14).

figure, ax = plt.subplots(layout="constrained")
ax.semilogy(branch.frequency, branch.error_estimate, ".", color="C0", markersize=3, label="estimated")
ax.semilogy(audit.frequency, audit.error, "s", color="C3", fillstyle="none", label="true")
ax.set_xlabel(r"fundamental frequency  $\Lambda$")
ax.set_ylim(1e-15, 0.1)
ax.set_ylabel("relative error of the waveform")
ax.legend()

# %%
# **Does the branch miss a motion?** Random starts of time integration find the stable motions, and the share of the starts that
# reach each.

attractors = train.attractors(frequency=0.6, starts=100)
for motion in attractors:
    print(f"period {motion.period}, rms {motion.rms.round(4)}, share {motion.share:.2f}")
plt.show()
