"""Gearboxes as REXS files, written after the published schema (fva-net/rexs-api-java): by version, as XML, JSON or zip."""

import base64
import json
import os
import struct
import sysconfig
import zipfile
from xml.sax.saxutils import escape, quoteattr


class Gearbox:
    """Components and relations of a file; each takes the number that follows."""

    def __init__(self, version="1.6"):
        self.version = version
        self.components = []
        self.relations = []
        self.load_cases = []
        self.unit = self.add("gear_unit", "Gear unit", gear_shift_index=("none", 1))
        self.casing = self.add("gear_casing", "Casing")

    def add(self, kind, name, **attributes):
        """Add a component; attributes are (unit, value)."""
        number = len(self.components) + 1
        self.components.append((number, kind, f"{name} [{number}]", dict(attributes)))
        return number

    def number(self, name):
        """Of the first component whose name begins so."""
        return next(number for number, _, full, _ in self.components if full.startswith(name))

    def change(self, name, **attributes):
        """Other attributes of the components whose names begin so; None leaves one out."""
        for place, (number, kind, full, old) in enumerate(self.components):
            if full.startswith(name):
                new = {key: value for key, value in {**old, **attributes}.items() if value is not None}
                self.components[place] = number, kind, full, new
        return self

    def relate(self, kind, **roles):
        self.relations.append((kind, roles))

    def shaft(self, name, sections, material=None, at=(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0), **attributes):
        """A shaft of sections (diameter, bore, length) in mm, the first at u = 0."""
        shaft = self.add("shaft", name, support_vector=("mm", list(at)), u_axis_vector=("mm", list(axis)), **attributes)
        u = 0.0
        for diameter, bore, length in sections:
            ends = diameter if isinstance(diameter, tuple) else (diameter, diameter)
            section = self.add("shaft_section", "section", u_coordinate_on_shaft=("mm", u), length=("mm", length),
                               outer_diameter_begin=("mm", ends[0]), outer_diameter_end=("mm", ends[1]),
                               inner_diameter_begin=("mm", bore), inner_diameter_end=("mm", bore))
            self.relate("assembly", assembly=shaft, part=section)
            u += length
        if material:
            self.relate("reference", origin=shaft, referenced=material)
        return shaft

    def gear(self, shaft, name, teeth, module, u, width, helix=0.0, shift=0.0, kind="cylindrical_gear", series="c25",
             material=None, **more):
        old = self.version in ("1.0", "1.1", "1.2")
        word = "din_3967_deviation_tolerance_series" if self.version == "1.0" else \
            "tooth_thickness_deviation_tolerance_series_din_3967_1978"
        if series:
            more[word] = ("none", series)
        begin = u - width / 2 if self.version == "1.0" else u
        gear = self.add(kind, name, number_of_teeth=("none", teeth), normal_module=("mm", module), face_width=("mm", width),
                        helix_angle_reference_diameter=("°" if old else "deg", helix), u_coordinate_on_shaft=("mm", begin), **more)
        self.relate("assembly", assembly=shaft, part=gear)
        flank = "flank_geometry" if old else "cylindrical_gear_flank"
        flanks = [self.add(flank, f"{name} {side}", normal_pressure_angle=("deg", 20.0),
                           addendum_modification_coefficient=("none", shift)) for side in ("left", "right")]
        self.relate("flank", gear=gear, left=flanks[0], right=flanks[1])
        if material:
            self.relate("reference", origin=gear, referenced=material)
        return gear

    def stage(self, name, one, other, distance=None, **more):
        if distance is not None:
            more["center_distance"] = ("mm", distance)
        stage = self.add("cylindrical_stage", name, **more)
        self.relate("stage", stage=stage, gear_1=one, gear_2=other)
        return stage

    def load(self, shaft, name, u, **attributes):
        load = self.add("external_load", name, u_coordinate_on_shaft=("mm", u), transmits_torque=("none", True), **attributes)
        self.relate("assembly", assembly=shaft, part=load)
        return load

    def couple(self, kind, name, inner, outer, stiffness=1e20, **attributes):
        coupling = self.add(kind, name, rotational_stiffness=("N mm / rad", stiffness), **attributes)
        self.relate("side", assembly=coupling, inner_part=inner, outer_part=outer)
        return coupling

    def steel(self, modulus=210000.0, density=7.85):
        return self.add("material", "Steel", elastic_modulus=("N / mm^2", modulus), poisson_ratio=("none", 0.3),
                        density=("kg / dm^3", density))

    # As files.

    def xml(self):
        lines = ['<?xml version="1.0" encoding="UTF-8"?>',
                 f'<model applicationId="by hand" applicationVersion="1" version="{self.version}">',
                 "<relations>"]
        for number, (kind, roles) in enumerate(self.relations, 1):
            refs = "".join(f'<ref id="{part}" role="{role}"/>' for role, part in roles.items())
            lines.append(f'<relation id="{number}" type="{kind}">{refs}</relation>')
        lines += ["</relations>", "<components>", *self._xml_components(self.components), "</components>"]
        if self.load_cases:
            lines.append('<load_spectrum id="1">')
            for number, case in enumerate(self.load_cases, 1):
                lines += [f'<load_case id="{number}">', *self._xml_components(case), "</load_case>"]
            lines.append("</load_spectrum>")
        return "\n".join([*lines, "</model>", ""])

    @staticmethod
    def _xml_components(components):
        for number, kind, name, attributes in components:
            yield f'<component id="{number}" name={quoteattr(name)} type="{kind}">'
            for word, (unit, value) in attributes.items():
                if isinstance(value, list):
                    text = "<array>" + "".join(f"<c>{str(item).lower()}</c>" for item in value) + "</array>"
                else:
                    text = escape(str(value).lower() if isinstance(value, bool) else str(value))
                yield f'<attribute id="{word}" unit="{unit}">{text}</attribute>'
            yield "</component>"

    def json(self, coded=False):
        def component(number, kind, name, attributes):
            return {"id": number, "type": kind, "name": name,
                    "attributes": [{"id": word, "unit": unit, **typed(value)} for word, (unit, value) in attributes.items()]}

        def typed(value):
            if isinstance(value, list) and coded and isinstance(value[0], float):
                data = base64.b64encode(struct.pack(f"<{len(value)}d", *value)).decode()
                return {"floating_point_array_coded": {"code": "float64", "value": data}}
            if isinstance(value, list):
                return {("boolean" if isinstance(value[0], bool) else "floating_point") + "_array": value}
            kinds = {bool: "boolean", int: "integer", float: "floating_point", str: "string"}
            return {kinds[type(value)]: value}

        relations = [{"id": number, "type": kind, "refs": [{"id": part, "role": role} for role, part in roles.items()]}
                     for number, (kind, roles) in enumerate(self.relations, 1)]
        model = {"version": self.version, "applicationId": "by hand", "relations": relations,
                 "components": [component(*row) for row in self.components]}
        if self.load_cases:
            model["load_spectrum"] = {"id": 1, "load_cases": [{"id": number, "components": [component(*row) for row in case]}
                                                              for number, case in enumerate(self.load_cases, 1)]}
        return json.dumps({"model": model}, indent=1)

    def write(self, path):
        """Write the format that the name tells."""
        if path.suffix == ".rexsz":
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("model.rexs", self.xml())
        else:
            path.write_text(self.json() if path.suffix == ".rexsj" else self.xml(), encoding="utf-8")
        return path


def two_stages(version="1.6", torque=True, **changes):
    """A reducer of two helical stages, driven at 1500 1/min by 90 N m, the load at the other end."""
    box = Gearbox(version)
    steel = box.steel()
    loads = {"torque_around_u_axis": ("N m", 90.0)} if torque else {}
    first = box.shaft("Input", [(30.0, 0.0, 200.0)], steel, defines_speed=("none", True), rotational_speed=("1 / min", 1500.0))
    middle = box.shaft("Middle", [(40.0, 10.0, 100.0), ((40.0, 50.0), 10.0, 60.0)], steel, at=(100.0, 122.0, 0.0))
    last = box.shaft("Output", [(60.0, 0.0, 250.0)], steel, at=(100.0, 122.0, 206.0))
    pinion = box.gear(first, "Pinion 1", 23, 2.5, 150.0, 42.0, 15.0, 0.1, material=steel)
    wheel = box.gear(middle, "Wheel 1", 71, 2.5, 30.0, 40.0, -15.0, 0.0, material=steel)
    pinion_2 = box.gear(middle, "Pinion 2", 19, 4.0, 110.0, 72.0, 15.0, 0.2, material=steel)
    wheel_2 = box.gear(last, "Wheel 2", 80, 4.0, 60.0, 70.0, -15.0, 0.0, material=steel)
    box.stage("Stage 1", pinion, wheel, 122.0)
    box.stage("Stage 2", pinion_2, wheel_2, 206.0)
    box.load(first, "Motor", 10.0, defines_torque=("none", True), **loads)
    box.load(last, "Machine", 240.0)
    return box


def one_stage(version="1.6"):
    """A pair of spur gears at 1500 1/min and 90 N m."""
    box = Gearbox(version)
    steel = box.steel()
    first = box.shaft("Input", [(30.0, 0.0, 200.0)], steel, defines_speed=("none", True), rotational_speed=("1 / min", 1500.0))
    last = box.shaft("Output", [(60.0, 20.0, 250.0)], steel, at=(100.0, 118.0, 0.0))
    pinion = box.gear(first, "Pinion", 23, 2.5, 150.0, 42.0, 0.0, 0.1, material=steel)
    wheel = box.gear(last, "Wheel", 71, 2.5, 50.0, 40.0, 0.0, 0.1, material=steel)
    box.stage("Stage", pinion, wheel, 118.0)
    box.load(first, "Motor", 10.0, defines_torque=("none", True), torque_around_u_axis=("N m", 90.0))
    box.load(last, "Machine", 240.0)
    return box


def planetary(planets=3, version="1.6", held=True, angles=None, spring=None):
    """A planetary stage: the sun is driven at 1500 1/min by 100 kW, the ring coupled to the casing, the carrier drives the load."""
    from math import cos, radians, sin

    box = Gearbox(version)
    steel = box.steel()
    box.add("lubricant", "Oil")
    sun_shaft = box.shaft("Sun shaft", [(34.0, 0.0, 150.0)], steel,
                          defines_speed=("none", True), rotational_speed=("1 / min", 1500.0))
    ring_shaft = box.shaft("Ring shaft", [(300.0, 260.0, 50.0)], steel)
    carrier_shaft = box.shaft("Carrier shaft", [(80.0, 60.0, 100.0)], steel, at=(-100.0, 0.0, 0.0))
    sun = box.gear(sun_shaft, "Sun", 17, 4.0, 25.0, 50.0, material=steel)
    ring = box.gear(ring_shaft, "Ring", 61, 4.0, 25.0, 50.0, kind="ring_gear", material=steel)
    carrier, stage = box.add("planet_carrier", "Carrier"), box.add("planetary_stage", "Set")
    plate = box.add("side_plate", "Plate", outer_diameter=("mm", 219.0), inner_diameter=("mm", 80.0), length=("mm", 8.0))
    box.relate("assembly", assembly=stage, part=carrier)
    box.relate("assembly", assembly=carrier, part=plate)
    box.relate("central_shaft", planetary_stage=stage, shaft=sun_shaft)
    box.relate("central_shaft", planetary_stage=stage, shaft=ring_shaft)
    box.relate("planet_carrier_shaft", planetary_stage=stage, shaft=carrier_shaft)
    box.couple("coupling", "Hub", carrier_shaft, plate, u_coordinate_on_shaft_inner_side=("mm", 95.0))
    for angle in angles or [360 / planets * place for place in range(planets)]:
        at = (0.0, 78 * sin(radians(angle)), 78 * cos(radians(angle)))
        shaft = box.shaft("Planet shaft", [(40.0, 30.0, 50.0)], steel, at=at)
        pin = box.shaft("Pin", [(20.0, 0.0, 60.0)], steel, at=at)
        planet = box.gear(shaft, "Planet", 22, 4.0, 25.0, 50.0, material=steel)
        box.relate("planet_shaft", planetary_stage=stage, shaft=shaft)
        box.relate("planet_pin", planetary_stage=stage, shaft=pin)
        for name, pair in (("Sun mesh", (sun, planet)), ("Ring mesh", (planet, ring))):
            box.relate("assembly", assembly=stage, part=box.stage(name, *pair, 78.0))
    box.couple("switchable_coupling", "Brake", ring_shaft, box.casing, spring or 1e20, is_engaged=("none", [held]),
               u_coordinate_on_shaft_inner_side=("mm", 25.0))
    box.load(sun_shaft, "Motor", 140.0, defines_torque=("none", True), power=("kW", 100.0))
    box.load(carrier_shaft, "Machine", 5.0)
    return box


def said(notes, kind, words):
    """Notes of a kind, ``assumed``, ``missing`` or ``not used``, that have these words."""
    return [note for note in notes if note.startswith(kind + ": ") and words in note]


def scripts():
    """An environment that finds the commands of the package."""
    return {**os.environ, "PATH": os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])}
