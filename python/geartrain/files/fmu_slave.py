"""What a functional mock-up unit of a train does where it runs; see fmu.py."""

from __future__ import annotations

import json
import re
import sys
import warnings
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import Fmi2Slave, Real
from pythonfmu.enums import Fmi2Causality, Fmi2Status, Fmi2Variability

from .._core.units import Unit
from ..case import read_case
from ..errors import InputError, Interrupted, SolverError
from ..results.simulator import Simulator

__all__ = ["TrainSlave"]

#: Units of the variables in those of SI: exponents and factor.
_UNITS: dict[str, dict[str, str]] = {
    "N": {"kg": "1", "m": "1", "s": "-2"}, "N.m": {"kg": "1", "m": "2", "s": "-2"}, "rad/s": {"rad": "1", "s": "-1"},
    "rev/min": {"rad": "1", "s": "-1", "factor": "0.10471975511965977"},
}


class TrainSlave(Fmi2Slave):  # type: ignore[misc]
    """A train with torques of bodies in, and forces, torques and speeds out; the torques are constant over a step."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(self.resources)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the case, which its reader has had
            self._train = read_case(folder / "case.nml").train
        self._settings = json.loads((folder / "unit.json").read_text())
        self._torque: dict[str, float] = {}
        self._units: dict[str, str] = {}
        self._wrong = ""
        self._simulator = self._begin(self._settings["frequency"], "Lambda")
        self.description = "Gear train by geartrain: torques of bodies in, forces, torques and speeds out"
        self._add("initial_speed", f"speed of {self._train.speed_name} at the beginning", "rev/min",
                  lambda: self._initial_speed, self._put_speed,
                  causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed)
        for body in self._settings["inputs"]:
            self._add(f"{_plain(body)}.torque", f"torque on {body}, positive as it turns", "N.m",
                      lambda body=body: self._torque.get(body, self._simulator.torque[body]),
                      lambda value, body=body: self._torque.update({body: value}), causality=Fmi2Causality.input)
        self._add("speed", f"speed of {self._train.speed_name} without its vibration", "rev/min", lambda: self._simulator.speed)
        for name in self._settings["outputs"]:
            what, unit = _kind(name, self._train.body_labels)
            self._add(f"{_plain(name)}.{what}", f"{what} of {name}", unit, lambda name=name: self._simulator.value(name))

    def _begin(self, frequency: float, unit: Unit) -> Simulator:
        simulator = Simulator(self._train, frequency, start=self._settings["state"], unit=unit)
        self._initial_speed = simulator.speed
        return simulator

    def _put_speed(self, value: float) -> None:
        # What is wrong ends the next step: an exception here would end the program that runs the unit.
        self._wrong = "initial_speed: can be set before the first step alone" if self._simulator.time > 0 else ""
        if not self._wrong:
            try:
                self._simulator = self._begin(value, "rpm")
            except InputError as error:
                self._wrong = f"initial_speed: {error}"

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Go on; what stops it is printed, since programs show their log of a unit only where asked, and ends the simulation."""
        try:
            if self._wrong:
                raise InputError(self._wrong)
            self._simulator.advance(step_size, self._torque)
        except (InputError, SolverError, Interrupted) as error:
            self.log(str(error), Fmi2Status.error)
            print(f"{self.instance_name}: {error}", file=sys.stderr)
            return False
        return True

    def to_xml(self, *options: Any) -> Element:
        """The model description, with units and with the outputs that exist from the beginning, which pythonfmu leaves out."""
        model: Element = super().to_xml(*options)
        definitions = Element("UnitDefinitions")
        for name in sorted(set(self._units.values())):
            SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", _UNITS[name])
        model.insert(1, definitions)
        known = SubElement(model[-1], "InitialUnknowns")
        for index, variable in enumerate(model.iter("ScalarVariable"), 1):
            variable[0].set("unit", self._units[variable.attrib["name"]])
            if variable.get("causality") == "output":
                SubElement(known, "Unknown", index=str(index))
        return model

    def _add(self, name: str, about: str, unit: str, getter: Any, setter: Any = None, **kind: Any) -> None:
        if name in self._units:
            raise InputError(f"path: two variables of the unit would be called {name}: rename a body")
        self._units[name] = unit
        kind = kind or {"causality": Fmi2Causality.output}
        self.register_variable(Real(name, description=about, getter=getter, setter=setter, **kind))


def _plain(name: str) -> str:
    """A name as programs can take it: letters, digits and underscores."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)


def _kind(name: str, bodies: tuple[str, ...]) -> tuple[str, str]:
    """What an output is, and its unit."""
    if name in bodies:
        return "speed", "rad/s"
    return ("torque", "N.m") if name.startswith(("shaft ", "coupling ")) else ("force", "N")
