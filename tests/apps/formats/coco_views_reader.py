"""Reads a COCO file of several cameras as COCO's own tools index it: annotations
by image, images by id; with Python's json. Prints key points by camera/frame."""

import json
import sys

with open(sys.argv[1]) as file:
    data = json.load(file)
category = {entry["id"]: entry for entry in data["categories"]}
images = {image["id"]: image for image in data["images"]}
assert len(images) == len(data["images"])
assert len({entry["id"] for entry in data["annotations"]}) == len(data["annotations"])
found = {}
for image in images.values():
    assert image["width"] == 1920 and image["height"] == 1080
    camera, name = image["file_name"].split("/")
    assert camera == image["camera"] and int(name.split(".")[0]) == image["frame_id"]
    found["%s/%d" % (camera, image["frame_id"])] = []
for entry in data["annotations"]:
    names = category[entry["category_id"]]["keypoints"]
    numbers = entry["keypoints"]
    assert len(numbers) == 3 * len(names) and not entry["iscrowd"]
    assert entry["num_keypoints"] == sum(v > 0 for v in numbers[2::3])
    left, top, width, height = entry["bbox"]
    points = {}
    for n, name in enumerate(names):
        x, y, v = numbers[3 * n : 3 * n + 3]
        if v == 0:
            continue
        # The sum of box and side may be rounded.
        assert left <= x <= left + width + 1e-9 and top <= y <= top + height + 1e-9
        points[name] = [x, y]
    image = images[entry["image_id"]]
    found["%s/%d" % (image["camera"], image["frame_id"])].append(points)
json.dump(
    {
        "rate": data["info"]["frame_rate"],
        "bones": [
            [names[a - 1], names[b - 1]]
            for a, b in data["categories"][0]["skeleton"]
        ],
        "found": found,
    },
    sys.stdout,
)
