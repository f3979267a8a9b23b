"""The variables of a case as keywords, with their types: made by scripts/signatures from the table of variables."""

# ruff: noqa: E501 (each variable has a line)

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from ._variable import Part, Series, Variable

if TYPE_CHECKING:
    from typing_extensions import Required

#: Groups of a case file, in its order, and their variables by their keywords.
VARIABLES: dict[str, dict[str, Variable]] = {
    "train": {
        "title": Variable("title", "text", "str", "", False, "A line of text that goes with the results"),
        "input_torque": Variable("input_torque", "real", "float", 0.0, False, "Mean torque on the driving end of a chain; the load torque balances it by itself; [N m]"),
        "torque_cos": Variable("torque_cos", "reals", "Series", None, False, "Cosine amplitudes of the input torque, orders 1, 2, ... of Lambda; [N m]"),
        "torque_sin": Variable("torque_sin", "reals", "Series", None, False, "Sine amplitudes, likewise; [N m]"),
        "prime_mover_inertia": Variable("prime_mover_inertia", "real", "float", 0.0, False, "Polar moment of inertia at the driving end of a chain; 0 only if the first shaft is rigid; [kg m^2]; >= 0"),
        "load_inertia": Variable("load_inertia", "real", "float", 0.0, False, "Polar moment of inertia at the driven end of a chain; 0 only if the last shaft is rigid; [kg m^2]; >= 0"),
        "characteristic_length": Variable("characteristic_length", "real", "float", None, False, "Unit in which mesh displacements are reported, b_c; may be left out where every mesh has teeth: 1e-6; [m]; > 0"),
        "characteristic_frequency": Variable("characteristic_frequency", "real", "float", None, False, "Unit in which frequencies are reported, omega_c; Lambda is the fundamental frequency over it. May be left out where every mesh has teeth: Lambda is then the speed in rpm; [rad/s]; > 0"),
        "modal_damping": Variable("modal_damping", "reals", "Series", None, False, "Damping ratios of modes 1, 2, ...; the last one is that of all higher modes. Shafts and meshes without damping of their own get the damping >= 0 that comes nearest to them; >= 0 and <= 1"),
        "speed_of": Variable("speed_of", "text", "str", "", False, "Name of the body whose revolutions are the speed in rpm; blank: the first body"),
    },
    "body": {
        "name": Variable("name", "text", "str", None, True, "By which shafts and meshes call it"),
        "inertia": Variable("inertia", "real", "float", None, False, "Polar moment of inertia; 0 only where rigid shafts alone join it with others. May be left out: then by outer_diameter, else that of its gears as discs of their pitch diameters; [kg m^2]; >= 0"),
        "outer_diameter": Variable("outer_diameter", "reals", "Series", None, False, "Diameters of discs whose inertias are added up; [m]; > 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the discs; none: 0, one: of all; [m]; >= 0"),
        "width": Variable("width", "reals", "Series", None, False, "Widths of the discs; [m]; > 0"),
        "density": Variable("density", "reals", "Series", None, False, "Densities of the discs; none: 7850, one: of all; [kg/m^3]; > 0"),
        "torque": Variable("torque", "real", "float", 0.0, False, "Mean torque on it, positive in the sense in which it turns; [N m]"),
        "torque_cos": Variable("torque_cos", "reals", "Series", None, False, "Cosine amplitudes of its torque, orders 1, 2, ... of Lambda; [N m]"),
        "torque_sin": Variable("torque_sin", "reals", "Series", None, False, "Sine amplitudes, likewise; [N m]"),
        "revolution_torque_cos": Variable("revolution_torque_cos", "reals", "Series", None, False, "Cosine amplitudes of its torque, orders 1, 2, ... of its own revolution; every mesh must have teeth; [N m]"),
        "revolution_torque_sin": Variable("revolution_torque_sin", "reals", "Series", None, False, "Sine amplitudes, likewise; [N m]"),
        "damping_to_ground": Variable("damping_to_ground", "real", "float", 0.0, False, "Damping of its vibration against the ground; none of its mean motion: a mean drag is a torque; [N m s/rad]; >= 0"),
        "balances": Variable("balances", "logical", "bool", False, False, "Its mean torque balances those of all others, in a run-up the acceleration of the inertias as well; true for exactly one body"),
    },
    "shaft": {
        "between": Variable("between", "names", "Sequence[str]", None, False, "Names of the two bodies that it joins; none in a chain"),
        "rigid": Variable("rigid", "logical", "bool", False, False, "The inertias at the ends of the shaft move as one; it then has neither stiffness nor damping"),
        "stiffness": Variable("stiffness", "real", "float", None, False, "Torsional stiffness; or rigid, or by diameter and length; [N m/rad]; > 0"),
        "diameter": Variable("diameter", "reals", "Series", None, False, "Diameters of sections in series: pi G (D^4 - d^4)/(32 l); [m]; > 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the sections; none: 0, one: of all; [m]; >= 0"),
        "length": Variable("length", "reals", "Series", None, False, "Lengths of the sections; [m]; > 0"),
        "shear_modulus": Variable("shear_modulus", "real", "float", 8.0e10, False, "Shear modulus, G; [N/m^2]; > 0"),
        "damping_ratio": Variable("damping_ratio", "real", "float", 0.0, False, "c/(2 sqrt(k m)) with 1/m = 1/I_a + 1/I_b of the bodies at the ends, without what is rigidly joined to them; of a train without &body with it; >= 0"),
        "damping": Variable("damping", "real", "float", None, False, "Damping coefficient, instead of damping_ratio; [N m s/rad]; >= 0"),
        "loss_factor": Variable("loss_factor", "real", "float", 0.0, False, "Structural damping, instead of damping_ratio: damping k loss_factor/omega, omega the natural frequency of the mode in which the shaft has most strain energy; >= 0 and <= 2"),
    },
    "mesh": {
        "between": Variable("between", "names", "Sequence[str]", None, False, "Names of the bodies that the driving and the driven gear are on; none in a chain"),
        "teeth": Variable("teeth", "reals", "Series", None, False, "Numbers of teeth of the driving and the driven gear; >= 3 and <= 100000"),
        "normal_module": Variable("normal_module", "real", "float", None, False, "Normal module; [m]; > 0"),
        "pressure_angle": Variable("pressure_angle", "real", "float", 20.0, False, "Normal pressure angle of the basic rack; [degree]; >= 10 and <= 35"),
        "helix_angle": Variable("helix_angle", "real", "float", 0.0, False, "Helix angle at the reference circle; [degree]; >= 0 and <= 60"),
        "face_width": Variable("face_width", "real", "float", None, False, "Common face width of the two gears; [m]; > 0"),
        "profile_shift": Variable("profile_shift", "reals", "Series", None, False, "Profile shift coefficients, positive towards the tips; none: 0; >= -2 and <= 2"),
        "centre_distance": Variable("centre_distance", "real", "float", None, False, "Distance of the axes; else with the flanks touching without backlash; [m]; > 0"),
        "tip_diameter": Variable("tip_diameter", "reals", "Series", None, False, "Tip diameters; else by the basic rack, shortened to keep its clearance; [m]; > 0"),
        "dedendum": Variable("dedendum", "real", "float", 1.25, False, "Dedendum of the basic rack, in modules; >= 1 and <= 2"),
        "backlash": Variable("backlash", "real", "float", 0.0, False, "Circumferential backlash along the working pitch circles, in the transverse plane; [m]; >= 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the gears, for their inertias; none: 0; [m]; >= 0"),
        "density": Variable("density", "real", "float", 7850.0, False, "Of the gears, for their inertias; [kg/m^3]; > 0"),
        "elastic_modulus": Variable("elastic_modulus", "reals", "Series", None, False, "Moduli of elasticity of the gears; none: steel, 2.06e11; [N/m^2]; > 0"),
        "driving_radius": Variable("driving_radius", "real", "float", None, False, "Base circle radius of the driving gear; or by teeth and normal_module; [m]; > 0"),
        "driven_radius": Variable("driven_radius", "real", "float", None, False, "Base circle radius of the driven gear; or by teeth and normal_module; [m]; > 0"),
        "driving_inertia": Variable("driving_inertia", "real", "float", None, False, "In a chain: polar moment of inertia of the driving gear; or as a disc of its pitch diameter; [kg m^2]; > 0"),
        "driven_inertia": Variable("driven_inertia", "real", "float", None, False, "In a chain: polar moment of inertia of the driven gear; or as a disc of its pitch diameter; [kg m^2]; > 0"),
        "internal": Variable("internal", "logical", "bool", False, False, "An internal gear pair: both gears turn in one sense"),
        "stiffness": Variable("stiffness", "real", "float", None, False, "Mean mesh stiffness along the line of action in the transverse plane; or by stiffness_table, or by ISO 6336-1 where the drawing is given, less below a line load of 100 N/mm; [N/m]; > 0"),
        "damping_ratio": Variable("damping_ratio", "real", "float", 0.0, False, "c/(2 sqrt(k m)) with m = I_a I_b/(r_a^2 I_b + r_b^2 I_a); >= 0"),
        "damping": Variable("damping", "real", "float", None, False, "Damping coefficient, instead of damping_ratio; [N s/m]; >= 0"),
        "loss_factor": Variable("loss_factor", "real", "float", 0.0, False, "Structural damping, instead of damping_ratio: damping k loss_factor/omega, omega the natural frequency of the mode in which the mesh has most strain energy; >= 0 and <= 2"),
        "damping_acts": Variable("damping_acts", "text", "Literal['always', 'contact']", "always", False, "At all times, or in contact only: not while the teeth are apart; 'always' or 'contact'"),
        "half_backlash": Variable("half_backlash", "real", "float", 0.0, False, "Half of the backlash along the line of action in the transverse plane, b; 0: no backlash, a linear mesh, unless `backlash` is given; [m]; >= 0"),
        "stiffness_cos": Variable("stiffness_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ... of kappa(t) = 1 + ..., the mesh stiffness over its mean"),
        "stiffness_sin": Variable("stiffness_sin", "reals", "Series", None, False, "Sine amplitudes, likewise"),
        "stiffness_table": Variable("stiffness_table", "reals", "Series", None, False, "Stiffness at equidistant instants of one mesh cycle, 4 values or more, taken as a trigonometric polynomial: gives stiffness and its harmonics; [N/m]; > 0"),
        "back_stiffness": Variable("back_stiffness", "real", "float", None, False, "Mean stiffness of the back flanks, which touch at p < -half_backlash, where it is not that of the drive flanks; [N/m]; > 0"),
        "back_phase": Variable("back_phase", "real", "float", 0.0, False, "By which kappa of the back flanks lags that of the drive flanks, in the mesh cycle; [rad]"),
        "contact_ratio": Variable("contact_ratio", "real", "float", None, False, "Gives kappa as the rectangular wave of as many tooth pairs in contact, instead of stiffness_cos and stiffness_sin. At phase = 0 the time with the extra pair is centred at the beginning of the cycle for ratios of 1 to 2, 3 to 4, ..., at half the cycle for 2 to 3, 4 to 5, ...; > 1 and <= 10"),
        "stiffness_harmonics": Variable("stiffness_harmonics", "integer", "int", 5, False, "Harmonics of the rectangular wave that are taken; >= 1 and <= 1000"),
        "phase": Variable("phase", "real", "float", 0.0, False, "By which kappa and the transmission error lag, in the mesh cycle; [rad]"),
        "error_cos": Variable("error_cos", "reals", "Series", None, False, "Cosine amplitudes of the static transmission error, harmonics 1, 2, ...; it adds to the mesh displacement; [m]"),
        "error_sin": Variable("error_sin", "reals", "Series", None, False, "Sine amplitudes, likewise; [m]"),
        "order": Variable("order", "integer", "int", 0, False, "Mesh frequency as a multiple of the fundamental, m_n; 0: by the teeth where every mesh has them, else 1; >= 1 and <= 1.0e6, or 0"),
    },
    "modes": {},
    "response": {
        "start": Variable("from", "real", "float", None, True, "Frequency or value of parameter at which the branch begins"),
        "stop": Variable("to", "real", "float", None, True, "Frequency or value of parameter at which it ends, above or below"),
        "parameter": Variable("parameter", "text", "str", "", False, "Number of the train that from and to are values of, at constant frequency, as in 'input_torque', 'mesh 2 half_backlash', 'mesh * damping_ratio', 'stiffness_variation'; blank: none, they are frequencies"),
        "frequency": Variable("frequency", "real", "float", None, False, "With parameter: the constant frequency; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "harmonics": Variable("harmonics", "integer", "int", 6, False, "Harmonics R of Lambda/subharmonic; 0: as many as tolerance needs, the choice for trains with teeth; >= 1 and <= 1000, or 0"),
        "subharmonic": Variable("subharmonic", "integer", "int", 1, False, "Period of the motion in periods of the fundamental, eta; >= 1 and <= 1000"),
        "stability": Variable("stability", "logical", "bool", True, False, "Whether every point is stable, by its Floquet multipliers or, where a period has more than 500 cycles of a mesh, its growth rate"),
        "multipliers": Variable("multipliers", "logical", "bool", False, False, "Floquet multipliers of every point to their digits, however long the period is and however large the train"),
        "shaft_torque": Variable("shaft_torque", "logical", "bool", True, False, "Mean and extremes of the torque of every shaft at every point"),
        "amplitude_limit": Variable("amplitude_limit", "real", "float", -1.0, False, "Rms over characteristic length beyond which the branch is followed but not recorded; -1: 12 with backlash, 10000 for a linear train, where it counts as infinite (both times the larger of half backlash and static deflection); > 0, or -1"),
        "coefficients": Variable("coefficients", "text", "Literal['exact', 'sampled']", "exact", False, "Fourier coefficients of the mesh force: exact from the contact events, or sampled (the discrete transform of the paper); 'exact' or 'sampled'"),
        "samples": Variable("samples", "integer", "int", 0, False, "Points a period for sampled coefficients; 0: chosen by the program; >= 1 and <= 1.048576e6, or 0"),
        "control": Variable("control", "text", "Literal['arclength', 'local']", "arclength", False, "pseudo-arclength, or the local switching of the control parameter of the paper, equation (11); 'arclength' or 'local'"),
        "tolerance": Variable("tolerance", "real", "float", 0.0001, False, "Relative error of the waveform aimed at where harmonics = 0; > 0 and <= 1"),
        "step": Variable("step", "real", "float", 0.2, False, "Largest step along the branch, in Lambda and mesh displacement together, each over the power of ten nearest to the own scale of the train (see docs/numerics.md); > 0"),
        "max_points": Variable("max_points", "integer", "int", 20000, False, "Points after which the branch is given up; >= 2 and <= 1.0e7"),
        "period_doublings": Variable("period_doublings", "integer", "int", 0, False, "How often a period doubling is followed: 1: the branches of twice the period, 2: those of four times as well, ...; >= 0 and <= 6"),
        "branch_points": Variable("branch_points", "logical", "bool", False, False, "The branches of the same period that cross at branch points are followed too: where a multiplier passes +1 without a fold, as where equal stages begin to move differently"),
        "refine": Variable("refine", "logical", "bool", False, False, "Every point polished by shooting to about 1e-11, multipliers included; in the end, further branches as well"),
    },
    "integration": {
        "start": Variable("from", "real", "float", None, True, "One end of the range of Lambda; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Its other end; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 121, False, "Frequencies in the range, both ends included; >= 1 and <= 100000"),
        "direction": Variable("direction", "text", "Literal['up', 'down', 'both']", "up", False, "Order in which the frequencies are visited, each starting from the motion before; 'up', 'down' or 'both'"),
        "harmonics": Variable("harmonics", "integer", "int", 0, False, "Harmonics of Lambda that are stored of the motion; 0: 16 of the highest mesh order; >= 1 and <= 20000, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 2000, False, "Periods of the fundamental after which an unsettled motion is given up; of a motion with a window 1000 cycles of the slowest mesh, if that is less; >= 1"),
        "window": Variable("window", "integer", "int", 0, False, "Cycles of the slowest mesh over which figures are taken, after settling by the time constants of the train; 0: 100 or more where the period has more than 200 such cycles, or 10 and some mesh is idle; else the figures are those of a period; >= 1 and <= 1.0e6, or 0"),
        "tolerance": Variable("tolerance", "real", "float", 1.0e-9, False, "Relative change over a period of the motion at which it counts as settled; > 0 and <= 1"),
        "stability": Variable("stability", "logical", "bool", False, False, "Floquet multipliers of every settled motion"),
    },
    "attractors": {
        "frequency": Variable("frequency", "real", "float", None, True, "Lambda, or in `unit; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "starts": Variable("starts", "integer", "int", 200, False, "Random starts: mesh displacements up to three times the resting displacement, velocities up to this amplitude times the frequency of the mesh vibrating alone; >= 1 and <= 1.0e6"),
        "random_seed": Variable("random_seed", "integer", "int", 0, False, "The same seed gives the same starts"),
        "follow": Variable("follow", "logical", "bool", False, False, "Each motion found that lies on no branch of the case yet is followed as one, over the range of &response and with its settings"),
        "harmonics": Variable("harmonics", "integer", "int", 0, False, "Harmonics of Lambda that are stored of each motion; 0: 16 of the highest mesh order; >= 1 and <= 20000, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 2000, False, "Periods of the fundamental after which an unsettled start is given up; >= 1"),
        "tolerance": Variable("tolerance", "real", "float", 1.0e-9, False, "Relative change over a period of the motion at which it counts as settled; > 0 and <= 1"),
        "stability": Variable("stability", "logical", "bool", True, False, "Floquet multipliers of every motion"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Computed even where a period has more than 500 cycles of a mesh, as with hunting teeth: minutes to days"),
    },
    "basins": {
        "frequency": Variable("frequency", "real", "float", None, True, "Lambda, or in `unit; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "mesh": Variable("mesh", "integer", "int", 1, False, "Number of the mesh whose displacement and velocity vary from start to start; >= 1"),
        "displacement_start": Variable("displacement_from", "real", "float", 0.0, False, "One end of the range of the displacement over the characteristic length; both 0: three times that at rest either way"),
        "displacement_stop": Variable("displacement_to", "real", "float", 0.0, False, "Its other end"),
        "displacement_points": Variable("displacement_points", "integer", "int", 200, False, "Starts along it, both ends included; >= 1 and <= 10000"),
        "velocity_start": Variable("velocity_from", "real", "float", 0.0, False, "One end of the range of the velocity over characteristic length times frequency; both 0: three times the displacement at rest, times the frequency of the mesh vibrating alone"),
        "velocity_stop": Variable("velocity_to", "real", "float", 0.0, False, "Its other end"),
        "velocity_points": Variable("velocity_points", "integer", "int", 200, False, "Starts along it, both ends included; >= 1 and <= 10000"),
        "starts": Variable("starts", "integer", "int", 200, False, "Random starts that find the motions first, as of &attractors; >= 1 and <= 1.0e6"),
        "random_seed": Variable("random_seed", "integer", "int", 0, False, "The same seed gives the same random starts"),
        "max_periods": Variable("max_periods", "integer", "int", 500, False, "Periods of the fundamental after which a start that goes to no known motion is settled the long way, and given up after 64 more; >= 1"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Computed even where a period has more than 500 cycles of a mesh, as with hunting teeth: minutes to days"),
    },
    "bifurcation_diagram": {
        "start": Variable("from", "real", "float", None, True, "One end of the range of Lambda; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Its other end; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 200, False, "Frequencies in the range, both ends included; >= 1 and <= 100000"),
        "direction": Variable("direction", "text", "Literal['up', 'down', 'both']", "both", False, "Order in which the frequencies are visited, each starting from the last state before; 'up', 'down' or 'both'"),
        "transient": Variable("transient", "integer", "int", 500, False, "Periods of the fundamental before the sections of a frequency; >= 0"),
        "sections": Variable("sections", "integer", "int", 200, False, "Sections of a frequency, one at phase 0 of each period of the fundamental; >= 10 and <= 100000"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Computed even where a period has more than 500 cycles of a mesh, as with hunting teeth: minutes to days"),
    },
    "stability_map": {
        "start": Variable("from", "real", "float", None, True, "One end of the range of Lambda; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Its other end; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 200, False, "Frequencies in the range, both ends included; >= 1 and <= 10000"),
        "parameter": Variable("parameter", "text", "str", "stiffness_variation", False, "Number of the train that varies from row to row, as in 'motor torque', 'shaft 2 stiffness', 'stiffness_variation' (the largest amplitude of any harmonic of kappa, all scaled alike); mesh_damping_ratio and half_backlash: of every mesh, in place of what a drawing gives"),
        "parameter_start": Variable("parameter_from", "real", "float", None, True, "One end of the range of the parameter, in its unit"),
        "parameter_stop": Variable("parameter_to", "real", "float", None, True, "Its other end"),
        "parameter_points": Variable("parameter_points", "integer", "int", 200, False, "Values of the parameter in the range, both ends included; >= 1 and <= 10000"),
        "linear": Variable("linear", "logical", "bool", False, False, "The train without backlash, all teeth in contact: where its parametric resonances are; else the motions on the branch of every row"),
        "harmonics": Variable("harmonics", "integer", "int", 6, False, "Harmonics R of Lambda of the motions; 0: chosen by the program for each point, as trains with teeth need; not used by a linear map; >= 1 and <= 1000, or 0"),
        "tolerance": Variable("tolerance", "real", "float", 0.0001, False, "Relative error of the waveform aimed at where harmonics = 0; > 0 and <= 1"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Computed even where a period has more than 500 cycles of a mesh, as with hunting teeth: minutes to days"),
    },
    "run_up": {
        "start": Variable("from", "real", "float", None, True, "Frequency at the beginning, in the `unit`; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Frequency at the end, above or below that at the beginning; > 0"),
        "duration": Variable("duration", "real", "float", None, True, "Time from the beginning to the end, in which the frequency changes linearly; [s]; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "samples": Variable("samples", "integer", "int", 0, False, "Equidistant samples of a period of the fundamental at the higher frequency; 0: 32 of the fastest mesh, more where harmonics of the excitation or vibrations of a mesh are faster; >= 1 and <= 1.0e8, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 2000, False, "Periods of the fundamental after which the search for the steady motion at the beginning is given up, or 1000 cycles of the slowest mesh where the common period is long, and the run-up begins with the state reached; 0: it begins at rest, or with the motion given in a call; >= 0"),
    },
    "locus": {
        "kind": Variable("kind", "text", "Literal['fold', 'period_doubling', 'neimark-sacker', 'branch_point', 'separation', 'back_contact']", "fold", False, "Kind of the special point; separation and back_contact: where a mesh begins to separate, or its back flanks to touch; 'fold', 'period_doubling', 'neimark-sacker', 'branch_point', 'separation' or 'back_contact'"),
        "near": Variable("near", "real", "float", None, True, "Frequency near which it is on the response, in the `unit; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Unit of the frequencies of the group: Lambda; rpm, the speed, of a train whose meshes all have teeth; Hz, of the fundamental; 'Lambda', 'rpm' or 'Hz'"),
        "mesh": Variable("mesh", "integer", "int", 0, False, "Number of the mesh that separates or whose back flanks touch; 0 for other kinds; >= 0"),
        "parameter": Variable("parameter", "text", "str", "", False, "Number of the train, as in 'input_torque', 'mesh 2 half_backlash', 'mesh * damping_ratio', 'stiffness_variation'; must be given"),
        "start": Variable("from", "real", "float", None, True, "Value of parameter at one end of the curve"),
        "stop": Variable("to", "real", "float", None, True, "Value of parameter at its other end, the value of the train between them"),
    },
    "output": {
        "file": Variable("file", "text", "str", "", False, "Name of the HDF5 file, relative to the working directory; empty: the name of the case file with .h5, in the working directory"),
    },
}


@dataclass(frozen=True, kw_only=True, repr=False)
class Body(Part, variables=VARIABLES["body"]):
    """A body that turns as one: a gear, a rotor."""

    name: str | None = None
    inertia: float | None = None
    outer_diameter: Series | None = None
    bore: Series | None = None
    width: Series | None = None
    density: Series | None = None
    torque: float | None = None
    torque_cos: Series | None = None
    torque_sin: Series | None = None
    revolution_torque_cos: Series | None = None
    revolution_torque_sin: Series | None = None
    damping_to_ground: float | None = None
    balances: bool | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Shaft(Part, variables=VARIABLES["shaft"]):
    """A shaft."""

    between: Sequence[str] | None = None
    rigid: bool | None = None
    stiffness: float | None = None
    diameter: Series | None = None
    bore: Series | None = None
    length: Series | None = None
    shear_modulus: float | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    loss_factor: float | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Mesh(Part, variables=VARIABLES["mesh"]):
    """A gear pair."""

    between: Sequence[str] | None = None
    teeth: Series | None = None
    normal_module: float | None = None
    pressure_angle: float | None = None
    helix_angle: float | None = None
    face_width: float | None = None
    profile_shift: Series | None = None
    centre_distance: float | None = None
    tip_diameter: Series | None = None
    dedendum: float | None = None
    backlash: float | None = None
    bore: Series | None = None
    density: float | None = None
    elastic_modulus: Series | None = None
    driving_radius: float | None = None
    driven_radius: float | None = None
    driving_inertia: float | None = None
    driven_inertia: float | None = None
    internal: bool | None = None
    stiffness: float | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    loss_factor: float | None = None
    damping_acts: Literal["always", "contact"] | None = None
    half_backlash: float | None = None
    stiffness_cos: Series | None = None
    stiffness_sin: Series | None = None
    stiffness_table: Series | None = None
    back_stiffness: float | None = None
    back_phase: float | None = None
    contact_ratio: float | None = None
    stiffness_harmonics: int | None = None
    phase: float | None = None
    error_cos: Series | None = None
    error_sin: Series | None = None
    order: int | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class TrainVariables(Part, variables=VARIABLES["train"]):
    """What a train is given by."""

    title: str | None = None
    input_torque: float | None = None
    torque_cos: Series | None = None
    torque_sin: Series | None = None
    prime_mover_inertia: float | None = None
    load_inertia: float | None = None
    characteristic_length: float | None = None
    characteristic_frequency: float | None = None
    modal_damping: Series | None = None
    speed_of: str | None = None
    bodies: Sequence[Body] = ()
    shafts: Sequence[Shaft] = ()
    meshes: Sequence[Mesh] = ()


#: Groups that are parts of the train: the keyword of their list, and their class.
PARTS: dict[str, tuple[str, type[Part]]] = {
    "body": ("bodies", Body),
    "shaft": ("shafts", Shaft),
    "mesh": ("meshes", Mesh),
}

#: Analyses that a case may ask for, in their order.
ANALYSES = ("modes", "response", "integration", "attractors", "basins", "bifurcation_diagram", "stability_map", "run_up", "locus")


class Analyses(TypedDict, total=False):
    """Analyses that a case may ask for, each by its variables."""

    modes: bool
    response: Mapping[str, Any] | None
    integration: Mapping[str, Any] | None
    attractors: Mapping[str, Any] | None
    basins: Mapping[str, Any] | None
    bifurcation_diagram: Mapping[str, Any] | None
    stability_map: Mapping[str, Any] | None
    run_up: Mapping[str, Any] | None
    locus: Mapping[str, Any] | None


class ResponseKeywords(TypedDict, total=False):
    """Variables of ``&response`` that a call takes."""

    start: Required[float]
    stop: Required[float]
    parameter: str
    frequency: float | None
    unit: Literal["Lambda", "rpm", "Hz"]
    harmonics: int
    subharmonic: int
    stability: bool
    multipliers: bool
    shaft_torque: bool
    amplitude_limit: float
    coefficients: Literal["exact", "sampled"]
    samples: int
    control: Literal["arclength", "local"]
    tolerance: float
    step: float
    max_points: int
    period_doublings: int
    branch_points: bool
    refine: bool


class IntegrationKeywords(TypedDict, total=False):
    """Variables of ``&integration`` that a call takes."""

    start: Required[float]
    stop: Required[float]
    unit: Literal["Lambda", "rpm", "Hz"]
    points: int
    direction: Literal["up", "down", "both"]
    harmonics: int
    max_periods: int
    window: int
    tolerance: float
    stability: bool


class AttractorsKeywords(TypedDict, total=False):
    """Variables of ``&attractors`` that a call takes."""

    unit: Literal["Lambda", "rpm", "Hz"]
    starts: int
    random_seed: int
    harmonics: int
    max_periods: int
    tolerance: float
    stability: bool
    long_period: bool


class BasinsKeywords(TypedDict, total=False):
    """Variables of ``&basins`` that a call takes."""

    unit: Literal["Lambda", "rpm", "Hz"]
    displacement_start: float
    displacement_stop: float
    velocity_start: float
    velocity_stop: float
    starts: int
    random_seed: int
    max_periods: int
    long_period: bool


class BifurcationDiagramKeywords(TypedDict, total=False):
    """Variables of ``&bifurcation_diagram`` that a call takes."""

    start: Required[float]
    stop: Required[float]
    unit: Literal["Lambda", "rpm", "Hz"]
    points: int
    direction: Literal["up", "down", "both"]
    transient: int
    sections: int
    long_period: bool


class StabilityMapKeywords(TypedDict, total=False):
    """Variables of ``&stability_map`` that a call takes."""

    start: Required[float]
    stop: Required[float]
    unit: Literal["Lambda", "rpm", "Hz"]
    points: int
    parameter: str
    parameter_start: Required[float]
    parameter_stop: Required[float]
    parameter_points: int
    linear: bool
    harmonics: int
    tolerance: float
    long_period: bool


class RunUpKeywords(TypedDict, total=False):
    """Variables of ``&run_up`` that a call takes."""

    start: Required[float]
    stop: Required[float]
    duration: Required[float]
    unit: Literal["Lambda", "rpm", "Hz"]
    samples: int
    max_periods: int


class LocusKeywords(TypedDict, total=False):
    """Variables of ``&locus`` that a call takes."""

    kind: Literal["fold", "period_doubling", "neimark-sacker", "branch_point", "separation", "back_contact"]
    near: Required[float]
    unit: Literal["Lambda", "rpm", "Hz"]
    mesh: int
    parameter: str
    start: Required[float]
    stop: Required[float]


class IntegrateKeywords(TypedDict, total=False):
    """Variables of ``&integration`` that a call takes."""

    unit: Literal["Lambda", "rpm", "Hz"]
    harmonics: int
    max_periods: int
    window: int
    tolerance: float
    stability: bool
