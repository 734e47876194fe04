"""Reads a COCO-style file of 3D key points with Python's json, prints JSON."""

import json
import sys

with open(sys.argv[1]) as file:
    data = json.load(file)
category = data["categories"][0]
names = category["keypoints"]
images = {image["id"]: image for image in data["images"]}
assert len(images) == len(data["images"])
people = {}
for entry in data["annotations"]:
    assert entry["image_id"] in images and entry["category_id"] == category["id"]
    numbers = entry["keypoints_3d"]
    assert len(numbers) == 4 * len(names)
    points = {
        name: numbers[4 * j : 4 * j + 4]
        for j, name in enumerate(names)
        if numbers[4 * j + 3] > 0
    }
    assert entry["num_keypoints"] == len(points)
    people["%d/%d" % (entry["image_id"], entry["track_id"])] = points
json.dump(
    {
        "times": {str(frame): image["time_s"] for frame, image in images.items()},
        "bones": [[names[a - 1], names[b - 1]] for a, b in category["skeleton"]],
        "rate": data["info"]["frame_rate"],
        "people": people,
    },
    sys.stdout,
)
