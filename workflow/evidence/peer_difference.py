#!/usr/bin/env python3
"""How far two programs' results of one take lie apart, as JSON.

    peer_difference.py points OURS.jsonl THEIRS.jsonl
    peer_difference.py angles OURS.csv THEIRS.csv

Points: of tracks, the person of ours who is nearest to the one of theirs: frames
that both have, median and 90 % quantile of the distance [mm], median by joint.
Angles: of tables of `kinematics`, person 0 of ours: median absolute difference
[degrees] by angle.
"""
import csv
import json
import re
import statistics
import sys


def ours_of(name):
    """RSmallToe is r_small_toe, Head is head_top."""
    words = re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()
    return "head_top" if words == "head" else words


def tracks(path):
    """{person: {(frame, joint): place}}"""
    lines = [json.loads(line) for line in open(path)]
    joints = [ours_of(name) for name in lines[0]["skeleton"]["joints"]]
    people = {}
    for line in lines[1:]:
        for person in line["people"]:
            places = people.setdefault(person["id"], {})
            for name, place in zip(joints, person["joints"]):
                if place is not None:
                    places[line["frame"], name] = place
    return people


def distances_mm(ours, theirs):
    return {key: 1e3 * sum((a - b)**2 for a, b in zip(ours[key], theirs[key]))**0.5
            for key in ours.keys() & theirs.keys()}


def points(ours, theirs):
    (other,) = tracks(theirs).values()
    nearest = min((distances_mm(one, other) for one in tracks(ours).values()),
                  key=lambda d: statistics.median(d.values()))
    joints = {}
    for (_, name), distance in nearest.items():
        joints.setdefault(name, []).append(distance)
    return {"frames": len({frame for frame, _ in nearest}),
            "median_mm": statistics.median(nearest.values()),
            "p90_mm": statistics.quantiles(nearest.values(), n=10)[-1],
            "joints_mm": {name: statistics.median(values)
                          for name, values in sorted(joints.items())}}


def angles(ours, theirs):
    def rows(path):
        with open(path) as file:
            return {row["frame"]: row for row in csv.DictReader(file)
                    if row["id"] == "0"}

    ours, theirs = rows(ours), rows(theirs)
    frames = ours.keys() & theirs.keys()
    found = {}
    for column in next(iter(theirs.values())):
        if not column.endswith("_deg") or column not in next(iter(ours.values())):
            continue
        pairs = [(ours[f][column], theirs[f][column]) for f in frames]
        differences = [abs(float(a) - float(b)) for a, b in pairs if a and b]
        if differences:
            found[column[:-len("_deg")]] = statistics.median(differences)
    return {"frames": len(frames), "degrees": found}


if __name__ == "__main__":
    print(json.dumps({"points": points, "angles": angles}[sys.argv[1]](*sys.argv[2:])))
