#!/usr/bin/env python3
"""Two figures from real frames of Shelf: what part-aware association changes,
and what the joints filter refuses.

  paper_figures.py CALIBRATION DETECTIONS BODY PART NO_FILTER OUT

Tracks with output.observations: body-aware and part-aware association, and the
latter without the joints filter. Writes OUT/association.svg, OUT/filter.svg and
OUT/figures.json, which says what they show.
"""
import json
import pathlib
import sys

COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]
QUIET, REFUSED = "#b0b0b0", "#000000"
WIDTH, HEIGHT, TITLE = 516, 388, 26  # of a panel; half a picture's size


def tracks(path):
    lines = [json.loads(line) for line in open(path)]
    return lines[0], {line["frame"]: line["people"] for line in lines[1:]}


def detections(folder):
    found = {}
    for path in sorted(pathlib.Path(folder).glob("cam*.json")):
        for one in json.loads(path.read_text()):
            frame = found.setdefault((path.stem, one["image_id"]), [])
            frame.append([one["keypoints"][i:i + 3] for i in range(0, 51, 3)])
    return found


def project(camera, joints):
    K, RT = camera["K"], camera["RT"]
    pixels = []
    for x in joints:
        at = [sum(RT[4 * r + c] * (x + [1])[c] for c in range(4)) for r in range(3)]
        pixels.append((K[0] * at[0] / at[2] + K[2], K[4] * at[1] / at[2] + K[5]))
    return pixels


class Svg:
    def __init__(self, panels, title):
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 '
            f'{panels * (WIDTH + 8) - 8} {HEIGHT + TITLE}" '
            f'font-family="sans-serif" font-size="15"><title>{title}</title>']

    def panel(self, index, title):
        x = index * (WIDTH + 8)
        self.parts.append(
            f'<g transform="translate({x},{TITLE})"><text y="-8">{title}</text>'
            f'<clipPath id="c{index}"><rect width="{WIDTH}" height="{HEIGHT}"/>'
            f'</clipPath><rect width="{WIDTH}" height="{HEIGHT}" fill="#fff" '
            f'stroke="#888"/><g clip-path="url(#c{index})">')

    def end_panel(self):
        self.parts.append("</g></g>")

    def skeleton(self, points, bones, colour, width, dash=""):
        for a, b in bones:
            (x, y), (u, v) = points[a], points[b]
            self.parts.append(
                f'<line x1="{x / 2:.1f}" y1="{y / 2:.1f}" x2="{u / 2:.1f}" '
                f'y2="{v / 2:.1f}" stroke="{colour}" stroke-width="{width}"'
                f'{dash}/>')

    def cross(self, point):
        x, y = point[0] / 2, point[1] / 2
        self.parts.append(
            f'<path d="M{x - 6:.1f} {y - 6:.1f}l12 12m0-12l-12 12" '
            f'stroke="{REFUSED}" stroke-width="2.5"/>')

    def write(self, path):
        pathlib.Path(path).write_text("\n".join(self.parts + ["</svg>"]) + "\n")


def owners(people, view):
    return {p["matches"][view]: p["id"] for p in people if view in p["matches"]}


def draw_association(header, body, part, found, out):
    """The view and frame in which most detections change their owner."""
    changed = {}
    for (view, frame), shown in found.items():
        before = owners(body.get(frame, []), view)
        after = owners(part.get(frame, []), view)
        count = sum(before.get(d) != after.get(d) for d in range(len(shown)))
        changed[view, frame] = count
    view, frame = max(sorted(changed), key=changed.get)
    bones = header["skeleton"]["bones"]
    svg = Svg(2, "Body-aware and part-aware association")
    for index, (name, people) in enumerate([("body-aware", body),
                                            ("part-aware", part)]):
        svg.panel(index, f"{name}, {view}, frame {frame}")
        of = owners(people.get(frame, []), view)
        for d, joints in enumerate(found[view, frame]):
            colour = COLOURS[of[d] % len(COLOURS)] if d in of else QUIET
            svg.skeleton([j[:2] for j in joints], bones, colour, 3)
        svg.end_panel()
    svg.write(f"{out}/association.svg")
    return {"view": view, "frame": frame, "changed": changed[view, frame],
            "detections": len(found[view, frame]),
            "detections_changed_in_all": sum(changed.values()),
            "detections_in_all": sum(len(d) for d in found.values())}


def draw_filter(header, cameras, part, without, found, out):
    """The detection of which the filter refuses most joints, of those that no
    edge of the picture cuts."""
    refused, whole = {}, set()
    for frame, people in part.items():
        for p in people:
            for view, weights in p["weights"].items():
                key = frame, p["id"], view
                refused[key] = weights.count(0)
                joints = found[view, frame][p["matches"][view]]
                inside = all(20 < j[0] < 2 * WIDTH - 20 and
                             20 < j[1] < 2 * HEIGHT - 20 for j in joints)
                if inside and any(q["id"] == p["id"] and view in q["matches"]
                                  for q in without.get(frame, [])):
                    whole.add(key)
    frame, person, view = max(sorted(whole), key=refused.get)
    bones = header["skeleton"]["bones"]
    camera = cameras[view[3:]]
    svg = Svg(2, "What the joints filter refuses")
    for index, (name, of) in enumerate([("no joints filter", without),
                                        ("joints filter", part)]):
        svg.panel(index, f"{name}, {view}, frame {frame}")
        one = next(p for p in of[frame] if p["id"] == person)
        if view in one["matches"]:
            joints = [j[:2] for j in found[view, frame][one["matches"][view]]]
            svg.skeleton(joints, bones, COLOURS[0], 3)
            if index == 1:
                for joint, weight in zip(joints, one["weights"][view]):
                    if weight == 0:
                        svg.cross(joint)
        svg.skeleton(project(camera, one["joints"]), bones, COLOURS[1], 2,
                     ' stroke-dasharray="6 4"')
        svg.end_panel()
    svg.write(f"{out}/filter.svg")
    return {"view": view, "frame": frame, "refused": refused[frame, person, view],
            "refused_in_all": sum(refused.values()),
            "joints_in_all": 17 * len(refused)}


def main():
    calibration, folder, body, part, without, out = sys.argv[1:]
    cameras = json.loads(pathlib.Path(calibration).read_text())
    found = detections(folder)
    header, with_parts = tracks(part)
    figures = {
        "association": draw_association(header, tracks(body)[1], with_parts,
                                        found, out),
        "filter": draw_filter(header, cameras, with_parts, tracks(without)[1],
                              found, out)}
    pathlib.Path(f"{out}/figures.json").write_text(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
