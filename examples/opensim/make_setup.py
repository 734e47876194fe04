"""OpenSim files for scaling and inverse kinematics from kinegraph's TRC. UNTESTED
in OpenSim: written from its documentation (Scale and IK settings files, 4.x).

    python3 make_setup.py person_0.trc Rajagopal2016.osim OUT [--mass=KG]

The TRC comes from `kinegraph convert --to=trc --markers=opensim` (the names of
kinegraph and of Pose2Sim work too), with COCO-17, BODY_25 or another skeleton
with at least eight of their limb, neck and nose joints. Writes OUT/markers.xml,
OUT/scale.xml, OUT/ik.xml and OUT/run.py, and prints how to run them. Does not
need OpenSim itself.

Markers are joint centres. In OpenSim's whole-body models (Rajagopal 2016,
gait2392 with arms) a segment's origin is the centre of its proximal joint, so
most markers are at the origin of a segment.
"""

import argparse
import os
import sys
import xml.etree.ElementTree as ET

# Joint: segment, position in it [m], weight in inverse kinematics. Origins are
# exact in the models named above; other positions are those of a generic adult
# and have less weight.
JOINTS = {}
for side in ("l", "r"):
    JOINTS.update(
        {
            f"{side}_hip": (f"femur_{side}", (0, 0, 0), 2.0),
            f"{side}_knee": (f"tibia_{side}", (0, 0, 0), 2.0),
            f"{side}_ankle": (f"talus_{side}", (0, 0, 0), 2.0),
            f"{side}_heel": (f"calcn_{side}", (0, 0.02, 0), 1.0),
            f"{side}_big_toe": (
                f"toes_{side}",
                (0.04, 0, -0.02 if side == "r" else 0.02),
                1.0,
            ),
            f"{side}_small_toe": (
                f"toes_{side}",
                (0.02, 0, 0.04 if side == "r" else -0.04),
                0.5,
            ),
            f"{side}_shoulder": (f"humerus_{side}", (0, 0, 0), 2.0),
            f"{side}_elbow": (f"ulna_{side}", (0, 0, 0), 2.0),
            f"{side}_wrist": (f"hand_{side}", (0, 0, 0), 2.0),
        }
    )
JOINTS["neck"] = ("torso", (0, 0.38, 0), 0.5)
JOINTS["nose"] = ("torso", (0.11, 0.55, 0), 0.1)

# Other names of the same joints: those of --markers=pose2sim and opensim.
NAMES = {
    "Neck": "neck",
    "Nose": "nose",
    **{
        f"{side.upper()}{name}": f"{side}_{joint}"
        for side in ("l", "r")
        for name, joint in (
            ("Hip", "hip"),
            ("Knee", "knee"),
            ("Ankle", "ankle"),
            ("Heel", "heel"),
            ("BigToe", "big_toe"),
            ("SmallToe", "small_toe"),
            ("Shoulder", "shoulder"),
            ("Elbow", "elbow"),
            ("Wrist", "wrist"),
        )
    },
}

# Limbs, scaled by the distance between two joints, both sides together. The
# trunk's height and width and the pelvis are added in scale_tool().
MEASUREMENTS = (
    ("thigh", ("hip", "knee"), ("femur",)),
    ("shank", ("knee", "ankle"), ("tibia",)),
    ("foot", ("heel", "big_toe"), ("talus", "calcn", "toes")),
    ("upper_arm", ("shoulder", "elbow"), ("humerus",)),
    ("forearm", ("elbow", "wrist"), ("ulna", "radius", "hand")),
)


def read_trc(path):
    """Marker names, and the first and last time [s]."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        sys.exit(f"{path}: not a TRC file")
    markers = [cell for cell in lines[3].split("\t")[2:] if cell]
    rows = [line for line in lines[5:] if line.strip()]
    return markers, float(rows[0].split("\t")[1]), float(rows[-1].split("\t")[1])


def joints_of(markers):
    """Maps joints in JOINTS to their names in the TRC."""
    found = {}
    for marker in markers:
        joint = NAMES.get(marker, marker)
        if joint in JOINTS:
            found[joint] = marker
    return found


def child(parent, tag, text=None, **attributes):
    element = ET.SubElement(parent, tag, attributes)
    if text is not None:
        element.text = str(text)
    return element


def write(path, tool):
    document = ET.Element("OpenSimDocument", {"Version": "40000"})
    document.append(tool)
    ET.indent(document)
    ET.ElementTree(document).write(path, encoding="UTF-8", xml_declaration=True)


def marker_set(joints):
    tool = ET.Element("MarkerSet", {"name": "kinegraph"})
    objects = child(tool, "objects")
    for joint, marker in joints.items():
        segment, place, _ = JOINTS[joint]
        element = child(objects, "Marker", name=marker)
        child(element, "socket_parent_frame", f"/bodyset/{segment}")
        child(element, "location", " ".join(str(x) for x in place))
        child(element, "fixed", "true")
    return tool


def measurement(objects, name, pairs, segments, axes):
    element = child(objects, "Measurement", name=name)
    child(element, "apply", "true")
    pair_set = child(child(element, "MarkerPairSet"), "objects")
    for pair in pairs:
        child(child(pair_set, "MarkerPair"), "markers", " ".join(pair))
    scale_set = child(child(element, "BodyScaleSet"), "objects")
    for segment in segments:
        child(child(scale_set, "BodyScale", name=segment), "axes", axes)


def scale_tool(joints, arguments, trc, span):
    tool = ET.Element("ScaleTool", {"name": "person"})
    child(tool, "mass", arguments.mass)
    maker = child(tool, "GenericModelMaker")
    child(maker, "model_file", os.path.abspath(arguments.model))
    child(maker, "marker_set_file", "markers.xml")
    scaler = child(tool, "ModelScaler")
    child(scaler, "apply", "true")
    child(scaler, "scaling_order", "measurements")
    objects = child(child(scaler, "MeasurementSet", name="kinegraph"), "objects")
    for name, ends, segments in MEASUREMENTS:
        pairs, bodies = [], []
        for side in ("l", "r"):
            both = [joints.get(f"{side}_{end}") for end in ends]
            if None in both:
                continue
            pairs.append(both)
            bodies += [f"{segment}_{side}" for segment in segments]
        if pairs:
            measurement(objects, name, pairs, bodies, "X Y Z")
    if {"l_hip", "r_hip", "l_shoulder", "r_shoulder"} <= set(joints):
        sides = [
            (joints[f"{side}_hip"], joints[f"{side}_shoulder"])
            for side in ("l", "r")
        ]
        measurement(objects, "trunk", sides, ["torso"], "X Y")
        hips = [(joints["l_hip"], joints["r_hip"])]
        measurement(objects, "pelvis", hips, ["pelvis"], "X Y Z")
        shoulders = [(joints["l_shoulder"], joints["r_shoulder"])]
        measurement(objects, "shoulders", shoulders, ["torso"], "Z")
    child(scaler, "marker_file", trc)
    child(scaler, "time_range", span)
    child(scaler, "preserve_mass_distribution", "true")
    child(scaler, "output_model_file", "scaled.osim")
    # Markers are joint centres: none is moved to its measured position.
    child(child(tool, "MarkerPlacer"), "apply", "false")
    return tool


def ik_tool(joints, trc, span):
    tool = ET.Element("InverseKinematicsTool", {"name": "person"})
    child(tool, "model_file", "scaled.osim")
    child(tool, "constraint_weight", "Inf")
    child(tool, "accuracy", "1e-05")
    objects = child(child(tool, "IKTaskSet"), "objects")
    for joint, marker in joints.items():
        task = child(objects, "IKMarkerTask", name=marker)
        child(task, "apply", "true")
        child(task, "weight", JOINTS[joint][2])
    child(tool, "marker_file", trc)
    child(tool, "time_range", span)
    child(tool, "report_errors", "true")
    child(tool, "output_motion_file", "angles.mot")
    return tool


RUN = '''"""Scales the model and solves the inverse kinematics. UNTESTED."""

import opensim

opensim.ScaleTool("scale.xml").run()
opensim.InverseKinematicsTool("ik.xml").run()
'''


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("trc")
    parser.add_argument("model", help="a generic .osim model")
    parser.add_argument("out", help="folder to write")
    parser.add_argument("--mass", type=float, default=75.0, help="kg")
    arguments = parser.parse_args()
    markers, first, last = read_trc(arguments.trc)
    joints = joints_of(markers)
    if len(joints) < 8:
        sys.exit(f"{arguments.trc}: {len(joints)} known markers, expected 8 or more")
    os.makedirs(arguments.out, exist_ok=True)
    trc, span = os.path.abspath(arguments.trc), f"{first} {last}"

    def out(name):
        return os.path.join(arguments.out, name)

    write(out("markers.xml"), marker_set(joints))
    write(out("scale.xml"), scale_tool(joints, arguments, trc, span))
    write(out("ik.xml"), ik_tool(joints, trc, span))
    with open(out("run.py"), "w", encoding="utf-8") as file:
        file.write(RUN)
    print(f"{len(joints)} of {len(markers)} markers -> {arguments.out}")
    print(f"  cd {arguments.out} && python3 run.py")
    print("  or: opensim-cmd run-tool scale.xml && opensim-cmd run-tool ik.xml")


if __name__ == "__main__":
    main()
