"""The variables of a case as keywords, with their types: made by scripts/signatures from the table of variables."""

# ruff: noqa: E501 (each variable has a line)

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from ._core.variable import Part, Series, Variable

if TYPE_CHECKING:
    from typing_extensions import Required

#: Groups of a case file, in its order, and their variables by their keywords.
VARIABLES: dict[str, dict[str, Variable]] = {
    "train": {
        "title": Variable("title", "text", "str", "", False, "A line of text that is stored with the results"),
        "input_torque": Variable("input_torque", "real", "float", None, False, "Mean torque at the driving end of a chain; the load torque balances it; [N m]"),
        "torque_cos": Variable("torque_cos", "reals", "Series", None, False, "Cosine amplitudes of the input torque, orders 1, 2, ... of Lambda; [N m]"),
        "torque_sin": Variable("torque_sin", "reals", "Series", None, False, "Sine amplitudes, orders 1, 2, ...; [N m]"),
        "prime_mover_inertia": Variable("prime_mover_inertia", "real", "float", None, False, "Polar moment of inertia at the driving end of a chain; 0 only if the first shaft is rigid; [kg m^2]; >= 0"),
        "load_inertia": Variable("load_inertia", "real", "float", None, False, "Polar moment of inertia at the driven end of a chain; 0 only if the last shaft is rigid; [kg m^2]; >= 0"),
        "characteristic_length": Variable("characteristic_length", "real", "float", None, False, "Unit of the mesh displacements in results, b_c; default where every mesh has teeth: 1e-6; [m]; > 0"),
        "characteristic_frequency": Variable("characteristic_frequency", "real", "float", None, False, "Unit of the frequencies in results, omega_c: Lambda is the fundamental frequency over omega_c. Default where every mesh has teeth: Lambda is the speed in rpm; [rad/s]; > 0"),
        "modal_damping": Variable("modal_damping", "reals", "Series", None, False, "Damping ratios of modes 1, 2, ...; the last value holds for all higher modes. Shafts and meshes without damping of their own get dampings >= 0 that approximate these ratios; 0 to 1"),
        "speed_of": Variable("speed_of", "text", "str", "", False, "Name of the body whose speed is given in rpm; blank: the first body"),
    },
    "body": {
        "name": Variable("name", "text", "str", None, True, "Name by which shafts and meshes refer to the body"),
        "inertia": Variable("inertia", "real", "float", None, False, "Polar moment of inertia; 0 only where all its connections are rigid shafts. Default: from outer_diameter, else of its gears as discs of their pitch diameters; [kg m^2]; >= 0"),
        "added_inertia": Variable("added_inertia", "real", "float", 0.0, False, "Adds to the inertia, given or not: of masses that the body carries, as a carrier its planets; [kg m^2]; >= 0"),
        "outer_diameter": Variable("outer_diameter", "reals", "Series", None, False, "Diameters of discs; their inertias are added; [m]; > 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the discs; one value: for all; none: 0; [m]; >= 0"),
        "width": Variable("width", "reals", "Series", None, False, "Widths of the discs; [m]; > 0"),
        "density": Variable("density", "reals", "Series", None, False, "Densities of the discs; one value: for all; none: 7850; [kg/m^3]; > 0"),
        "torque": Variable("torque", "real", "float", 0.0, False, "Mean torque on the body, positive in its sense of rotation; [N m]"),
        "torque_cos": Variable("torque_cos", "reals", "Series", None, False, "Cosine amplitudes of the torque on the body, orders 1, 2, ... of Lambda; [N m]"),
        "torque_sin": Variable("torque_sin", "reals", "Series", None, False, "Sine amplitudes, orders 1, 2, ...; [N m]"),
        "revolution_torque_cos": Variable("revolution_torque_cos", "reals", "Series", None, False, "Cosine amplitudes of the torque on the body, orders 1, 2, ... of its revolution, of a planet against its carrier; every mesh must have teeth; [N m]"),
        "revolution_torque_sin": Variable("revolution_torque_sin", "reals", "Series", None, False, "Sine amplitudes, orders 1, 2, ...; [N m]"),
        "torque_table": Variable("torque_table", "reals", "Series", None, False, "Torque at 4 or more equidistant angles of torque_revolutions from the beginning, joined by a trigonometric polynomial; adds to the other torques; every mesh must have teeth; [N m]"),
        "torque_revolutions": Variable("torque_revolutions", "integer", "int", 1, False, "Revolutions over which torque_table goes; 2: four strokes; 1 to 2"),
        "torque_speed_exponent": Variable("torque_speed_exponent", "real", "float", 0.0, False, "The mean torque is proportional to this power of the speed: 2 of propellers and fans, -1 at constant power; 0: the same at all speeds. Every mesh must have teeth, whose stiffness stays that of the torque as given; the slope of the torque damps no vibration; -4 to 4"),
        "torque_speed": Variable("torque_speed", "real", "float", None, False, "Speed of the body at which the mean torque is as given, where it follows the speed; [rpm]; > 0"),
        "damping_to_ground": Variable("damping_to_ground", "real", "float", 0.0, False, "Damping of the vibration of the body against the ground; give a mean drag as torque; [N m s/rad]; >= 0"),
        "stiffness_to_ground": Variable("stiffness_to_ground", "real", "float", 0.0, False, "Stiffness of a spring between the body and the ground; it bears a mean torque, and the body cannot turn; [N m/rad]; >= 0"),
        "held": Variable("held", "logical", "bool", False, False, "The body stands still, as a housing; its reaction torque is a result"),
        "speed_ratio": Variable("speed_ratio", "real", "float", 0.0, False, "Mean speed of the body over that of the body of speed_of, negative in the opposite sense; only where the gears leave it free, as in a differential"),
        "position": Variable("position", "reals", "Series", None, False, "Position of the axis in the transverse plane, x and y, where the body of speed_of turns from x to y; for meshes of bodies on bearings; [m]"),
        "balances": Variable("balances", "logical", "bool", False, False, "The mean torque of the body balances all other torques, in a run-up also the acceleration of the inertias; True for as many bodies as there are independent speeds, for none where a spring to ground holds the train"),
    },
    "planetary": {
        "name": Variable("name", "text", "str", None, True, "Name of the set: its planets are the bodies 'NAME planet 1', ..., its meshes are named 'NAME sun 1', ..., 'NAME ring 1', ..."),
        "sun": Variable("sun", "text", "str", "", False, "Body that is the sun; none: no sun"),
        "ring": Variable("ring", "text", "str", "", False, "Body that is the ring; none: no ring"),
        "carrier": Variable("carrier", "text", "str", "", False, "Body on which the planets ride"),
        "teeth": Variable("teeth", "reals", "Series", None, False, "Numbers of teeth of sun, planet and ring; 0 for a sun or ring that the set lacks; 0 to 100000"),
        "planets": Variable("planets", "integer", "int", 0, False, "Number of planets, equally spaced; or angles; 2 to 1000, or 0"),
        "angles": Variable("angles", "reals", "Series", None, False, "Angles of the planets on the carrier, in the sense in which the sun turns seen from the carrier; in place of planets; [degree]"),
        "driving": Variable("driving", "text", "Literal['sun', 'ring']", "sun", False, "Member that drives the planets, seen from the carrier: ring where the sun is driven, as in a wind turbine; 'sun' or 'ring'"),
        "normal_module": Variable("normal_module", "real", "float", None, True, "Normal module; [m]; > 0"),
        "pressure_angle": Variable("pressure_angle", "real", "float", 20.0, False, "Normal pressure angle of the basic rack; [degree]; 10 to 35"),
        "helix_angle": Variable("helix_angle", "real", "float", 0.0, False, "Helix angle at the reference circle; [degree]; 0 to 60"),
        "face_width": Variable("face_width", "real", "float", None, False, "Common face width of the gears; [m]; > 0"),
        "ring_face_width": Variable("ring_face_width", "real", "float", None, False, "Common face width of planets and ring, where it is not face_width; [m]; > 0"),
        "profile_shift": Variable("profile_shift", "reals", "Series", None, False, "Profile shift coefficients of sun, planet and ring, as of a mesh; -2 to 2"),
        "centre_distance": Variable("centre_distance", "real", "float", None, False, "Distance of the axes of sun and planets; default: the flanks touch without backlash; [m]; > 0"),
        "tip_diameter": Variable("tip_diameter", "reals", "Series", None, False, "Tip diameters of sun, planet and ring, as of a mesh; [m]; > 0"),
        "dedendum": Variable("dedendum", "real", "float", 1.25, False, "Dedendum of the basic rack over the module; 1 to 2"),
        "elastic_modulus": Variable("elastic_modulus", "reals", "Series", None, False, "Moduli of elasticity of sun, planet and ring; none: steel, 2.06e11; [N/m^2]; > 0"),
        "planet_inertia": Variable("planet_inertia", "real", "float", None, False, "Polar moment of inertia of a planet; default: of a disc of its pitch diameter, with face_width, planet_bore and density; [kg m^2]; > 0"),
        "planet_mass": Variable("planet_mass", "real", "float", None, False, "Mass of a planet; at the centre distance the masses of all planets add to the inertia of the carrier. Default: of the disc; 0 without face_width; [kg]; >= 0"),
        "planet_bore": Variable("planet_bore", "real", "float", 0.0, False, "Bore of the planets; [m]; >= 0"),
        "planet_errors": Variable("planet_errors", "reals", "Series", None, False, "Errors of the places of the planets along the line of action, a value a planet: the error_mean of both its meshes. Positive: against the push of the driving member; the planet bears more; [m]"),
        "density": Variable("density", "real", "float", 7850.0, False, "Density of the planets; [kg/m^3]; > 0"),
        "backlash": Variable("backlash", "reals", "Series", None, False, "Circumferential backlash at the working pitch circles of sun and ring meshes; one value: both; without it teeth never part, and pull where they would; [m]; >= 0"),
        "half_backlash": Variable("half_backlash", "reals", "Series", None, False, "Half of the backlash along the line of action of sun and ring meshes; one value: both, in place of backlash; [m]; >= 0"),
        "stiffness": Variable("stiffness", "reals", "Series", None, False, "Mean mesh stiffness of sun and ring meshes; one value: both; none: from the drawing by ISO 6336-1; [N/m]; > 0"),
        "damping_ratio": Variable("damping_ratio", "reals", "Series", None, False, "Damping ratio, as of a mesh, of sun and ring meshes; one value: both; >= 0"),
        "damping": Variable("damping", "reals", "Series", None, False, "Damping coefficient of sun and ring meshes; one value: both, in place of damping_ratio; [N s/m]; >= 0"),
        "loss_factor": Variable("loss_factor", "reals", "Series", None, False, "Structural damping, as of a mesh, of sun and ring meshes; one value: both, in place of damping_ratio; 0 to 2"),
        "damping_acts": Variable("damping_acts", "text", "Literal['always', 'contact']", "always", False, "Always, or only in contact: no damping while the teeth are apart; 'always' or 'contact'"),
        "contact_ratio": Variable("contact_ratio", "reals", "Series", None, False, "Contact ratio of sun and ring meshes; one value: both, which gives kappa as of a mesh; none: from the drawing; > 1 and <= 10"),
        "stiffness_harmonics": Variable("stiffness_harmonics", "integer", "int", 5, False, "Number of harmonics taken of the rectangular wave; 1 to 1000"),
        "sun_stiffness_cos": Variable("sun_stiffness_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ..., of kappa of the sun meshes, in place of contact_ratio"),
        "sun_stiffness_sin": Variable("sun_stiffness_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ..."),
        "ring_stiffness_cos": Variable("ring_stiffness_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ..., of kappa of the ring meshes, in place of contact_ratio"),
        "ring_stiffness_sin": Variable("ring_stiffness_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ..."),
        "sun_error_cos": Variable("sun_error_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ..., of the transmission error of the sun meshes; [m]"),
        "sun_error_sin": Variable("sun_error_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ...; [m]"),
        "ring_error_cos": Variable("ring_error_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ..., of the transmission error of the ring meshes; [m]"),
        "ring_error_sin": Variable("ring_error_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ...; [m]"),
        "ring_phase": Variable("ring_phase", "real", "float", 0.0, False, "Lag of kappa and transmission error of each ring mesh behind those of the sun mesh of its planet, in the mesh cycle; default: from tooth thickness and tips of the drawing, for kappa as contact_ratio gives it; [rad]; -6.2832 to 6.2832"),
        "order": Variable("order", "integer", "int", 0, False, "Mesh frequency over the fundamental frequency, as of a mesh; 1 to 1.0e6, or 0"),
    },
    "shaft": {
        "between": Variable("between", "names", "Sequence[str]", None, False, "Names of the bodies at its two ends; none in a chain"),
        "rigid": Variable("rigid", "logical", "bool", False, False, "The bodies at its ends turn as one; a rigid shaft has no stiffness and no damping"),
        "stiffness": Variable("stiffness", "real", "float", None, False, "Torsional stiffness; else from diameter and length; [N m/rad]; > 0"),
        "diameter": Variable("diameter", "reals", "Series", None, False, "Diameters of sections in series, each of stiffness pi G (D^4 - d^4)/(32 l); [m]; > 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the sections; one value: for all; none: 0; [m]; >= 0"),
        "length": Variable("length", "reals", "Series", None, False, "Lengths of the sections; [m]; > 0"),
        "shear_modulus": Variable("shear_modulus", "real", "float", 8.0e10, False, "Shear modulus, G; [N/m^2]; > 0"),
        "damping_ratio": Variable("damping_ratio", "real", "float", 0.0, False, "c/(2 sqrt(k m)) with 1/m = 1/I_a + 1/I_b of the bodies at its ends; in a chain I_a and I_b include rigidly joined inertias; >= 0"),
        "damping": Variable("damping", "real", "float", None, False, "Damping coefficient, in place of damping_ratio; [N m s/rad]; >= 0"),
        "loss_factor": Variable("loss_factor", "real", "float", 0.0, False, "Structural damping, in place of damping_ratio: damping k loss_factor/omega, omega the natural frequency of the mode in which the shaft has most strain energy; 0 to 2"),
    },
    "mesh": {
        "between": Variable("between", "names", "Sequence[str]", None, False, "Names of the bodies with the driving and the driven gear; none in a chain"),
        "name": Variable("name", "text", "str", "", False, "Label of the mesh in results; none: by the names of the bodies"),
        "carrier": Variable("carrier", "text", "str", "", False, "Name of the body on which both gears ride, the arm of a planetary stage; none: their axes stand still"),
        "teeth": Variable("teeth", "reals", "Series", None, False, "Numbers of teeth of the driving and the driven gear; 3 to 100000"),
        "normal_module": Variable("normal_module", "real", "float", None, False, "Normal module; [m]; > 0"),
        "pressure_angle": Variable("pressure_angle", "real", "float", 20.0, False, "Normal pressure angle of the basic rack; [degree]; 10 to 35"),
        "helix_angle": Variable("helix_angle", "real", "float", 0.0, False, "Helix angle at the reference circle; [degree]; 0 to 60"),
        "face_width": Variable("face_width", "real", "float", None, False, "Common face width of the two gears; [m]; > 0"),
        "profile_shift": Variable("profile_shift", "reals", "Series", None, False, "Profile shift coefficients, positive towards the tips; none: 0; -2 to 2"),
        "centre_distance": Variable("centre_distance", "real", "float", None, False, "Centre distance; default: the flanks touch without backlash; [m]; > 0"),
        "tip_diameter": Variable("tip_diameter", "reals", "Series", None, False, "Tip diameters; default: from the basic rack, shortened to keep its clearance where flanks without backlash touch; [m]; > 0"),
        "dedendum": Variable("dedendum", "real", "float", 1.25, False, "Dedendum of the basic rack over the module; 1 to 2"),
        "backlash": Variable("backlash", "real", "float", 0.0, False, "Circumferential backlash at the working pitch circles, in the transverse plane; [m]; >= 0"),
        "bore": Variable("bore", "reals", "Series", None, False, "Bores of the gears, for their inertias; none: 0; [m]; >= 0"),
        "density": Variable("density", "real", "float", 7850.0, False, "Density of the gears, for their inertias; [kg/m^3]; > 0"),
        "elastic_modulus": Variable("elastic_modulus", "reals", "Series", None, False, "Moduli of elasticity of the gears; none: steel, 2.06e11; [N/m^2]; > 0"),
        "driving_radius": Variable("driving_radius", "real", "float", None, False, "Base circle radius of the driving gear; else from teeth and normal_module; [m]; > 0"),
        "driven_radius": Variable("driven_radius", "real", "float", None, False, "Base circle radius of the driven gear; else from teeth and normal_module; [m]; > 0"),
        "driving_inertia": Variable("driving_inertia", "real", "float", None, False, "In a chain: polar moment of inertia of the driving gear; else of a disc of its pitch diameter; [kg m^2]; > 0"),
        "driven_inertia": Variable("driven_inertia", "real", "float", None, False, "In a chain: polar moment of inertia of the driven gear; else of a disc of its pitch diameter; [kg m^2]; > 0"),
        "internal": Variable("internal", "logical", "bool", False, False, "Internal gear pair: both gears turn in the same sense"),
        "stiffness": Variable("stiffness", "real", "float", None, False, "Mean mesh stiffness along the line of action in the transverse plane; else from stiffness_table, or from the drawing by ISO 6336-1, reduced below a line load of 100 N/mm; [N/m]; > 0"),
        "damping_ratio": Variable("damping_ratio", "real", "float", 0.0, False, "c/(2 sqrt(k m)) with m = I_a I_b/(r_a^2 I_b + r_b^2 I_a); >= 0"),
        "damping": Variable("damping", "real", "float", None, False, "Damping coefficient, in place of damping_ratio; [N s/m]; >= 0"),
        "loss_factor": Variable("loss_factor", "real", "float", 0.0, False, "Structural damping, in place of damping_ratio: damping k loss_factor/omega, omega the natural frequency of the mode in which the mesh has most strain energy; 0 to 2"),
        "damping_acts": Variable("damping_acts", "text", "Literal['always', 'contact']", "always", False, "Always, or only in contact: no damping while the teeth are apart; 'always' or 'contact'"),
        "half_backlash": Variable("half_backlash", "real", "float", 0.0, False, "Half of the backlash along the line of action in the transverse plane, b; 0: linear mesh, unless `backlash` is given; [m]; >= 0"),
        "stiffness_cos": Variable("stiffness_cos", "reals", "Series", None, False, "Cosine amplitudes, harmonics 1, 2, ... of kappa(t) = 1 + ..., the mesh stiffness over its mean"),
        "stiffness_sin": Variable("stiffness_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ..."),
        "stiffness_table": Variable("stiffness_table", "reals", "Series", None, False, "Stiffness at 4 or more equidistant instants of a mesh cycle, joined by a trigonometric polynomial; gives the mean stiffness and kappa. With table_loads: load over deflection, load after load; [N/m]; > 0"),
        "table_loads": Variable("table_loads", "reals", "Series", None, False, "Ascending loads at which stiffness_table gives the stiffness: at each instant the force is a polygon over the displacement, with corners at the mean deflections under the loads; half_backlash or backlash must be > 0; [N]; > 0"),
        "back_stiffness": Variable("back_stiffness", "real", "float", None, False, "Mean stiffness of the back flanks, which touch at p < -half_backlash; default: as the drive flanks; [N/m]; > 0"),
        "back_phase": Variable("back_phase", "real", "float", 0.0, False, "Lag of kappa of the back flanks behind kappa of the drive flanks, in the mesh cycle; [rad]"),
        "contact_ratio": Variable("contact_ratio", "real", "float", None, False, "Gives kappa as the rectangular wave of the number of tooth pairs in contact, in place of stiffness_cos and stiffness_sin. At phase = 0 the time with the extra pair is centred at the beginning of the cycle if the integer part of the ratio is odd, else at half the cycle; > 1 and <= 10"),
        "stiffness_harmonics": Variable("stiffness_harmonics", "integer", "int", 5, False, "Number of harmonics taken of the rectangular wave; 1 to 1000"),
        "phase": Variable("phase", "real", "float", 0.0, False, "Lag of kappa and of all errors, in the mesh cycle; 0 of a mesh of planets of a set: as their place behind the first planet makes it; [rad]"),
        "error_cos": Variable("error_cos", "reals", "Series", None, False, "Cosine amplitudes of the static transmission error, harmonics 1, 2, ...; it adds to the mesh displacement; its sign and phase against the stiffness matter; [m]"),
        "error_sin": Variable("error_sin", "reals", "Series", None, False, "Sine amplitudes, harmonics 1, 2, ...; [m]"),
        "error_table": Variable("error_table", "reals", "Series", None, False, "Transmission error at 4 or more equidistant instants of a mesh cycle, joined by a trigonometric polynomial, in place of error_cos and error_sin; its mean adds to error_mean; [m]; -1 to 1"),
        "error_mean": Variable("error_mean", "real", "float", 0.0, False, "Constant part of the transmission error, of placement and tooth thickness; positive: towards contact of the drive flanks. It matters in loops of gears alone, as between planets; [m]"),
        "driving_pitch_error": Variable("driving_pitch_error", "reals", "Series", None, False, "Cumulative pitch errors of the driving gear, one a tooth in the order in which the teeth engage, along the line of action; positive: towards the mate. Every mesh must have teeth; [m]; -1 to 1"),
        "driving_tooth_stiffness": Variable("driving_tooth_stiffness", "reals", "Series", None, False, "Stiffness of each tooth of the driving gear over that of a sound tooth, in the order of the pitch errors: 0.7 of a cracked tooth, 0 of a missing one. A factor of the mesh stiffness, which a cosine leads from tooth to tooth; 0 to 10"),
        "driving_runout": Variable("driving_runout", "real", "float", 0.0, False, "Amplitude of the error by eccentricity of the driving gear, along the line of action, once a revolution; [m]; 0 to 1"),
        "driving_runout_phase": Variable("driving_runout_phase", "real", "float", 0.0, False, "Angle of the driving gear at which its runout is largest, from the beginning of the first mesh cycle; [rad]"),
        "driving_error_cos": Variable("driving_error_cos", "reals", "Series", None, False, "Cosine amplitudes of the error of the driving gear, orders 1, 2, ... of its revolution, on a carrier against it; they add to pitch errors and runout; [m]; -1 to 1"),
        "driving_error_sin": Variable("driving_error_sin", "reals", "Series", None, False, "Sine amplitudes, orders 1, 2, ...; [m]; -1 to 1"),
        "driven_pitch_error": Variable("driven_pitch_error", "reals", "Series", None, False, "As driving_pitch_error, of the driven gear; [m]; -1 to 1"),
        "driven_tooth_stiffness": Variable("driven_tooth_stiffness", "reals", "Series", None, False, "As driving_tooth_stiffness, of the driven gear; 0 to 10"),
        "driven_runout": Variable("driven_runout", "real", "float", 0.0, False, "As driving_runout, of the driven gear; [m]; 0 to 1"),
        "driven_runout_phase": Variable("driven_runout_phase", "real", "float", 0.0, False, "As driving_runout_phase, of the driven gear; [rad]"),
        "driven_error_cos": Variable("driven_error_cos", "reals", "Series", None, False, "As driving_error_cos, of the driven gear; [m]; -1 to 1"),
        "driven_error_sin": Variable("driven_error_sin", "reals", "Series", None, False, "Sine amplitudes, orders 1, 2, ...; [m]; -1 to 1"),
        "pitch_error_form": Variable("pitch_error_form", "text", "Literal['polynomial', 'steps']", "polynomial", False, "Polynomial through the pitch errors, or steps from tooth to tooth, smoothed over the time in which two pairs bear by the contact ratio, which must be known, and over the face of helical teeth; 'polynomial' or 'steps'"),
        "line_of_action": Variable("line_of_action", "real", "float", 0.0, False, "Of bodies on bearings: direction in which the driving gear pushes the driven gear, from the x axis towards the y axis; default: from the positions of the axes; [degree]; -360 to 360"),
        "order": Variable("order", "integer", "int", 0, False, "Mesh frequency over the fundamental frequency, m_n; 0: from the teeth where every mesh has them, else 1; 1 to 1.0e6, or 0"),
    },
    "coupling": {
        "between": Variable("between", "names", "Sequence[str]", None, False, "Names of the two bodies"),
        "name": Variable("name", "text", "str", "", False, "Label in results; none: by the names of the bodies"),
        "stiffness": Variable("stiffness", "real", "float", None, False, "Torsional stiffness, in place of angle and torque; [N m/rad]; > 0"),
        "half_play": Variable("half_play", "real", "float", 0.0, False, "Half of the play; 0: none; [rad]; >= 0"),
        "angle": Variable("angle", "reals", "Series", None, False, "In place of stiffness and half_play: twists at the corners of a polygon, whose ends go on; [rad]"),
        "torque": Variable("torque", "reals", "Series", None, False, "Torques at the corners, ascending; 0 within a play; [N m]"),
        "damping_ratio": Variable("damping_ratio", "real", "float", 0.0, False, "c/(2 sqrt(k m)) as of a shaft, with the slope k beside the play on the side of positive torques or, without play, at the torque 0; >= 0"),
        "damping": Variable("damping", "real", "float", None, False, "Damping coefficient, in place of damping_ratio; [N m s/rad]; >= 0"),
        "loss_factor": Variable("loss_factor", "real", "float", 0.0, False, "Structural damping, in place of damping_ratio, as of a mesh; 0 to 2"),
        "friction_torque": Variable("friction_torque", "real", "float", 0.0, False, "Dry friction, beside stiffness and damping: up to this torque the coupling sticks; [N m]; >= 0"),
        "damping_acts": Variable("damping_acts", "text", "Literal['always', 'contact']", "always", False, "Always, or only in contact: no damping within the play; 'always' or 'contact'"),
    },
    "bearing": {
        "body": Variable("body", "text", "str", None, True, "Name of the body, which the bearing lets move in its transverse plane"),
        "mass": Variable("mass", "real", "float", None, True, "Mass of the body with what moves with it; [kg]; > 0"),
        "stiffness": Variable("stiffness", "reals", "Series", None, False, "Stiffnesses in the directions x and y, of all bearings of the body together; [N/m]; > 0"),
        "damping": Variable("damping", "reals", "Series", None, False, "Damping coefficients in the directions x and y, within the clearance as well; none: 0; [N s/m]; >= 0"),
        "half_clearance": Variable("half_clearance", "real", "float", 0.0, False, "Half of the clearance in each direction; 0: none; [m]; >= 0"),
        "flats": Variable("flats", "integer", "int", 4, False, "Flats of the clearance, 4, 8, 12, 16 or 24; above 4, of equal stiffness and damping in x and y, the clearance is nearly round; 4 to 24"),
    },
    "modes": {},
    "response": {
        "start": Variable("from", "real", "float", None, True, "Frequency, or value of parameter, at which the branch begins"),
        "stop": Variable("to", "real", "float", None, True, "Frequency, or value of parameter, at which the branch ends, above or below"),
        "parameter": Variable("parameter", "text", "str", "", False, "Number of the train that varies at constant frequency, as in 'input_torque', 'mesh 2 half_backlash', 'mesh * damping_ratio', 'stiffness_variation'; several that take the same value are separated by commas; blank: none"),
        "frequency": Variable("frequency", "real", "float", None, False, "Constant frequency of a branch over parameter; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "harmonics": Variable("harmonics", "integer", "int", 6, False, "Harmonics R of Lambda/subharmonic; 0: as many as tolerance needs, recommended for trains with teeth; 1 to 1000, or 0"),
        "subharmonic": Variable("subharmonic", "integer", "int", 1, False, "Period of the motion in periods of the fundamental, eta; 1 to 1000"),
        "stability": Variable("stability", "logical", "bool", True, False, "Stability of every point, by Floquet multipliers or, where a period has more than 500 cycles of a mesh, by the growth rate"),
        "multipliers": Variable("multipliers", "logical", "bool", False, False, "All Floquet multipliers of every point to full accuracy, also for long periods and large trains"),
        "shaft_torque": Variable("shaft_torque", "logical", "bool", True, False, "Mean and extremes of the torque of every shaft at every point"),
        "amplitude_limit": Variable("amplitude_limit", "real", "float", -1.0, False, "Rms over characteristic_length above which the branch is followed but not stored; -1: 12 times the larger of half backlash and static deflection, 10000 times for a linear train, where it counts as infinite; > 0, or -1"),
        "coefficients": Variable("coefficients", "text", "Literal['exact', 'sampled']", "exact", False, "Fourier coefficients of the mesh force: exact from the contact events, or sampled by the discrete transform of the paper; 'exact' or 'sampled'"),
        "samples": Variable("samples", "integer", "int", 0, False, "Samples per period for sampled coefficients; 0: chosen by the program; 1 to 1.048576e6, or 0"),
        "control": Variable("control", "text", "Literal['arclength', 'local']", "arclength", False, "Continuation by pseudo-arclength, or by local switching of the control parameter, equation (11) of the paper; 'arclength' or 'local'"),
        "tolerance": Variable("tolerance", "real", "float", 0.0001, False, "Relative error of the waveform to reach where harmonics = 0; > 0 and <= 1"),
        "step": Variable("step", "real", "float", 0.2, False, "Largest step along the branch: in Lambda and in mesh displacements together, each divided by a power of ten near its size in the train; > 0"),
        "max_points": Variable("max_points", "integer", "int", 20000, False, "Largest number of points; the branch ends there; 2 to 1.0e7"),
        "period_doublings": Variable("period_doublings", "integer", "int", 0, False, "Levels of period doubling to follow; 1: branches of twice the period, 2: also of four times the period, ...; 0 to 6"),
        "branch_points": Variable("branch_points", "logical", "bool", False, False, "Follow also the branches that cross at branch points, as where equal stages begin to move differently"),
        "refine": Variable("refine", "logical", "bool", False, False, "Refine every point by shooting to about 1e-11, with its multipliers, also on further branches"),
    },
    "integration": {
        "start": Variable("from", "real", "float", None, True, "One end of the frequency range; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Other end of the frequency range; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 121, False, "Frequencies in the range, both ends included; 1 to 100000"),
        "direction": Variable("direction", "text", "Literal['up', 'down', 'both']", "up", False, "Order of the frequencies; each starts from the motion before; 'up', 'down' or 'both'"),
        "harmonics": Variable("harmonics", "integer", "int", 0, False, "Harmonics of Lambda to store; 0: 16 times the highest mesh order; 1 to 20000, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 0, False, "Periods of the fundamental after which an unsettled motion is given up; with a window at most 1000 cycles of the slowest mesh; 0: 2000, or 40000 cycles of the fastest mesh if fewer, but 100; >= 1, or 0"),
        "window": Variable("window", "integer", "int", 0, False, "Window of the results in cycles of the slowest mesh, after settling by time constants; 0: at least 100 where the period has more than 200 such cycles, or 10 with an idle mesh; else one period; 1 to 1.0e6, or 0"),
        "tolerance": Variable("tolerance", "real", "float", 1.0e-9, False, "Relative change per period at which a motion counts as settled; > 0 and <= 1"),
        "stability": Variable("stability", "logical", "bool", False, False, "Floquet multipliers of every settled motion"),
    },
    "attractors": {
        "frequency": Variable("frequency", "real", "float", None, True, "Frequency, in `unit`; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "starts": Variable("starts", "integer", "int", 200, False, "Number of random starts: displacements up to three times the static displacement, velocities up to this displacement times the natural frequency of the mesh alone; 1 to 1.0e6"),
        "random_seed": Variable("random_seed", "integer", "int", 0, False, "The same seed gives the same starts"),
        "follow": Variable("follow", "logical", "bool", False, False, "Follow each motion that lies on no branch of the case as a further branch, over the range of &response and with its settings"),
        "harmonics": Variable("harmonics", "integer", "int", 0, False, "Harmonics of Lambda to store; 0: 16 times the highest mesh order; 1 to 20000, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 0, False, "Periods of the fundamental after which an unsettled start is given up; 0: as in an integration; >= 1, or 0"),
        "tolerance": Variable("tolerance", "real", "float", 1.0e-9, False, "Relative change per period at which a motion counts as settled; > 0 and <= 1"),
        "stability": Variable("stability", "logical", "bool", True, False, "Floquet multipliers of every motion"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Allow periods of more than 500 mesh cycles; takes minutes to days"),
    },
    "basins": {
        "frequency": Variable("frequency", "real", "float", None, True, "Frequency, in `unit`; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "mesh": Variable("mesh", "integer", "int", 1, False, "Number of the mesh whose displacement and velocity the starts vary; >= 1"),
        "displacement_start": Variable("displacement_from", "real", "float", 0.0, False, "Displacement at one end of the grid over characteristic_length; where both ends are 0, the range is plus and minus three times the static displacement"),
        "displacement_stop": Variable("displacement_to", "real", "float", 0.0, False, "Displacement at the other end of the grid"),
        "displacement_points": Variable("displacement_points", "integer", "int", 200, False, "Starts along the displacement, both ends included; 1 to 10000"),
        "velocity_start": Variable("velocity_from", "real", "float", 0.0, False, "Velocity at one end of the grid over characteristic_length times characteristic_frequency; both ends 0: plus and minus three times the static displacement times the natural frequency of the mesh alone"),
        "velocity_stop": Variable("velocity_to", "real", "float", 0.0, False, "Velocity at the other end of the grid"),
        "velocity_points": Variable("velocity_points", "integer", "int", 200, False, "Starts along the velocity, both ends included; 1 to 10000"),
        "starts": Variable("starts", "integer", "int", 200, False, "Random starts that find the motions first, as in &attractors; 1 to 1.0e6"),
        "random_seed": Variable("random_seed", "integer", "int", 0, False, "The same seed gives the same random starts"),
        "max_periods": Variable("max_periods", "integer", "int", 500, False, "Longest time of a start in periods of the fundamental; near no known motion it then goes on for up to 64 periods; >= 1"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Allow periods of more than 500 mesh cycles; takes minutes to days"),
    },
    "bifurcation_diagram": {
        "start": Variable("from", "real", "float", None, True, "One end of the frequency range; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Other end of the frequency range; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 200, False, "Frequencies in the range, both ends included; 1 to 100000"),
        "direction": Variable("direction", "text", "Literal['up', 'down', 'both']", "both", False, "Order of the frequencies; each starts from the last state before; 'up', 'down' or 'both'"),
        "transient": Variable("transient", "integer", "int", 500, False, "Periods of the fundamental that are left out before the sections; >= 0"),
        "sections": Variable("sections", "integer", "int", 200, False, "Sections at each frequency, one at phase 0 of each period of the fundamental; 10 to 100000"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Allow periods of more than 500 mesh cycles; takes minutes to days"),
    },
    "stability_map": {
        "start": Variable("from", "real", "float", None, True, "One end of the frequency range; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Other end of the frequency range; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "points": Variable("points", "integer", "int", 200, False, "Frequencies in the range, both ends included; 1 to 10000"),
        "parameter": Variable("parameter", "text", "str", "stiffness_variation", False, "Number of the train that varies from row to row, as in &response; mesh_damping_ratio and half_backlash: of every mesh"),
        "parameter_start": Variable("parameter_from", "real", "float", None, True, "One end of the range of the parameter"),
        "parameter_stop": Variable("parameter_to", "real", "float", None, True, "Other end of the range of the parameter"),
        "parameter_points": Variable("parameter_points", "integer", "int", 200, False, "Values of the parameter in the range, both ends included; 1 to 10000"),
        "linear": Variable("linear", "logical", "bool", False, False, "The train without backlash, all teeth in contact: shows parametric resonances; False: the motions on the branch of each row"),
        "harmonics": Variable("harmonics", "integer", "int", 6, False, "Harmonics R of Lambda; 0: as many as tolerance needs, recommended for trains with teeth; not used by a linear map; 1 to 1000, or 0"),
        "tolerance": Variable("tolerance", "real", "float", 0.0001, False, "Relative error of the waveform to reach where harmonics = 0; > 0 and <= 1"),
        "long_period": Variable("long_period", "logical", "bool", False, False, "Allow periods of more than 500 mesh cycles; takes minutes to days"),
    },
    "run_up": {
        "start": Variable("from", "real", "float", None, True, "Frequency at the beginning; > 0"),
        "stop": Variable("to", "real", "float", None, True, "Frequency at the end, above or below the beginning; > 0"),
        "duration": Variable("duration", "real", "float", None, True, "Time from the beginning to the end; [s]; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "samples": Variable("samples", "integer", "int", 0, False, "Samples per period of the fundamental at the higher frequency; 0: at least 32 per cycle of the fastest mesh; 1 to 1.0e8, or 0"),
        "max_periods": Variable("max_periods", "integer", "int", 2000, False, "Longest settling before the run-up, in periods of the fundamental, never more than an integration takes by default; 0: start at rest, or from the motion given in a call; >= 0"),
    },
    "locus": {
        "kind": Variable("kind", "text", "Literal['fold', 'period_doubling', 'neimark-sacker', 'branch_point', 'separation', 'back_contact']", "fold", False, "Kind of the point; separation and back_contact are the onsets of tooth separation and of contact of the back flanks; 'fold', 'period_doubling', 'neimark-sacker', 'branch_point', 'separation' or 'back_contact'"),
        "near": Variable("near", "real", "float", None, True, "Frequency near which the point lies on the response; > 0"),
        "unit": Variable("unit", "text", "Literal['Lambda', 'rpm', 'Hz']", "Lambda", False, "Rpm only where every mesh has teeth; 'Lambda', 'rpm' or 'Hz'"),
        "mesh": Variable("mesh", "integer", "int", 0, False, "Number of the mesh of a contact onset; 0 for other kinds; >= 0"),
        "parameter": Variable("parameter", "text", "str", "", False, "Number of the train that varies, as in &response; must be given"),
        "start": Variable("from", "real", "float", None, True, "Value of parameter at one end of the curve"),
        "stop": Variable("to", "real", "float", None, True, "Value of parameter at the other end; the value of the train lies between"),
    },
    "output": {
        "file": Variable("file", "text", "str", "", False, "Name of the HDF5 file, relative to the working directory; blank: the name of the case file with .h5"),
    },
}


@dataclass(frozen=True, kw_only=True, repr=False)
class Body(Part, variables=VARIABLES["body"]):
    """A body that turns as one: a gear, a rotor."""

    name: str | None = None
    inertia: float | None = None
    added_inertia: float | None = None
    outer_diameter: Series | None = None
    bore: Series | None = None
    width: Series | None = None
    density: Series | None = None
    torque: float | None = None
    torque_cos: Series | None = None
    torque_sin: Series | None = None
    revolution_torque_cos: Series | None = None
    revolution_torque_sin: Series | None = None
    torque_table: Series | None = None
    torque_revolutions: int | None = None
    torque_speed_exponent: float | None = None
    torque_speed: float | None = None
    damping_to_ground: float | None = None
    stiffness_to_ground: float | None = None
    held: bool | None = None
    speed_ratio: float | None = None
    position: Series | None = None
    balances: bool | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Planetary(Part, variables=VARIABLES["planetary"]):
    """A planetary set: a short form of bodies, its planets, and of their meshes with sun and ring, in place of which it stands.."""

    name: str | None = None
    sun: str | None = None
    ring: str | None = None
    carrier: str | None = None
    teeth: Series | None = None
    planets: int | None = None
    angles: Series | None = None
    driving: Literal["sun", "ring"] | None = None
    normal_module: float | None = None
    pressure_angle: float | None = None
    helix_angle: float | None = None
    face_width: float | None = None
    ring_face_width: float | None = None
    profile_shift: Series | None = None
    centre_distance: float | None = None
    tip_diameter: Series | None = None
    dedendum: float | None = None
    elastic_modulus: Series | None = None
    planet_inertia: float | None = None
    planet_mass: float | None = None
    planet_bore: float | None = None
    planet_errors: Series | None = None
    density: float | None = None
    backlash: Series | None = None
    half_backlash: Series | None = None
    stiffness: Series | None = None
    damping_ratio: Series | None = None
    damping: Series | None = None
    loss_factor: Series | None = None
    damping_acts: Literal["always", "contact"] | None = None
    contact_ratio: Series | None = None
    stiffness_harmonics: int | None = None
    sun_stiffness_cos: Series | None = None
    sun_stiffness_sin: Series | None = None
    ring_stiffness_cos: Series | None = None
    ring_stiffness_sin: Series | None = None
    sun_error_cos: Series | None = None
    sun_error_sin: Series | None = None
    ring_error_cos: Series | None = None
    ring_error_sin: Series | None = None
    ring_phase: float | None = None
    order: int | None = None


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
    name: str | None = None
    carrier: str | None = None
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
    table_loads: Series | None = None
    back_stiffness: float | None = None
    back_phase: float | None = None
    contact_ratio: float | None = None
    stiffness_harmonics: int | None = None
    phase: float | None = None
    error_cos: Series | None = None
    error_sin: Series | None = None
    error_table: Series | None = None
    error_mean: float | None = None
    driving_pitch_error: Series | None = None
    driving_tooth_stiffness: Series | None = None
    driving_runout: float | None = None
    driving_runout_phase: float | None = None
    driving_error_cos: Series | None = None
    driving_error_sin: Series | None = None
    driven_pitch_error: Series | None = None
    driven_tooth_stiffness: Series | None = None
    driven_runout: float | None = None
    driven_runout_phase: float | None = None
    driven_error_cos: Series | None = None
    driven_error_sin: Series | None = None
    pitch_error_form: Literal["polynomial", "steps"] | None = None
    line_of_action: float | None = None
    order: int | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Coupling(Part, variables=VARIABLES["coupling"]):
    """A torsional coupling with play or in stages, as a spline or a clutch damper."""

    between: Sequence[str] | None = None
    name: str | None = None
    stiffness: float | None = None
    half_play: float | None = None
    angle: Series | None = None
    torque: Series | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    loss_factor: float | None = None
    friction_torque: float | None = None
    damping_acts: Literal["always", "contact"] | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Bearing(Part, variables=VARIABLES["bearing"]):
    """A bearing of a body, which then moves in its transverse plane as well as it turns."""

    body: str | None = None
    mass: float | None = None
    stiffness: Series | None = None
    damping: Series | None = None
    half_clearance: float | None = None
    flats: int | None = None


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
    planetaries: Sequence[Planetary] = ()
    shafts: Sequence[Shaft] = ()
    meshes: Sequence[Mesh] = ()
    couplings: Sequence[Coupling] = ()
    bearings: Sequence[Bearing] = ()


#: Groups that are parts of the train: the keyword of their list, and their class.
PARTS: dict[str, tuple[str, type[Part]]] = {
    "body": ("bodies", Body),
    "planetary": ("planetaries", Planetary),
    "shaft": ("shafts", Shaft),
    "mesh": ("meshes", Mesh),
    "coupling": ("couplings", Coupling),
    "bearing": ("bearings", Bearing),
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
