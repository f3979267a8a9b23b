"""
Is it right? Your own case
==========================

Four questions that any case answers for itself. Harmonic balance and shooting share the model and the law of the mesh, and nothing
else: neither the transform nor the stability nor the estimate of the error.
"""

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case("../../namelists/fig03.nml").train
branch = train.response(start=0.2, stop=2.6, harmonics=12)

# %%
# **Is the train what I meant?** ``explain`` tells every number that was given or derived, ``modes`` the natural frequencies.

print(train.explain()["mesh 1"])
print(train.modes())

# %%
# **Are the points and what is told of them right?** The audit solves points drawn at random, and all folds and changes of
# stability, anew by shooting. From the shell it is ``geartrain --audit CASE.nml``.

audit = branch.audit(points=20)
print(audit)
assert audit.ok

# %%
# **Are there enough harmonics?** Each point has an estimate of its error; ``harmonics=0`` with a ``tolerance`` chooses them.
# Here it stands beside the true error, the distance to the orbit that shooting gives (to about 1e-14).

figure, ax = plt.subplots(layout="constrained")
ax.semilogy(branch.frequency, branch.error_estimate, ".", color="C0", markersize=3, label="estimated")
ax.semilogy(audit.frequency, audit.error, "s", color="C3", fillstyle="none", label="true")
ax.set_xlabel(r"fundamental frequency  $\Lambda$")
ax.set_ylim(1e-15, 0.1)
ax.set_ylabel("relative error of the waveform")
ax.legend()

# %%
# **Is there a motion that the branch does not know?** Random starts of time integration find what attracts; the shares are those of
# the starts that settle there.

attractors = train.attractors(frequency=0.6, starts=100)
for motion in attractors:
    print(f"period {motion.period}, rms {motion.rms.round(4)}, share {motion.share:.2f}")
