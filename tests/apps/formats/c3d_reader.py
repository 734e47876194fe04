"""Reads a C3D file as c3d.org's user guide describes it and prints JSON.

Written for the tests, independently of the writer: parameters are found
through their pointers, and values in both header and parameters must agree.
"""

import json
import math
import struct
import sys

BLOCK = 512


def value_of(data, at):
    kind, count = struct.unpack_from("bB", data, at)
    shape = list(data[at + 2 : at + 2 + count])
    at += 2 + count
    total = math.prod(shape)
    if kind == -1:
        text = data[at : at + total]
        return [
            text[i : i + shape[0]].decode("utf-8").rstrip(" ")
            for i in range(0, total, shape[0])
        ]
    code = {1: "b", 2: "H", 4: "f"}[kind]
    numbers = list(struct.unpack_from("<" + str(total) + code, data, at))
    return numbers if shape else numbers[0]


def parameters_of(data, start):
    assert data[start + 3] == 84, "little-endian numbers"
    groups, values = {}, {}
    at = start + 4
    while at < start + data[start + 2] * BLOCK:
        length, group = struct.unpack_from("bb", data, at)
        if length == 0:
            break
        here = at + 2 + abs(length)
        name = data[at + 2 : here].decode("ascii")
        (step,) = struct.unpack_from("<H", data, here)
        if group < 0:
            groups[-group] = name
        else:
            values[(group, name)] = value_of(data, here + 2)
        if step == 0:
            break
        at = here + step
    result = {name: {} for name in groups.values()}
    for (group, name), value in values.items():
        result[groups[group]][name] = value
    return result


def labels_of(point):
    labels = list(point["LABELS"])
    part = 2
    while "LABELS%d" % part in point:
        labels += point["LABELS%d" % part]
        part += 1
    return labels


def points_of(data, at, count, scale):
    for _ in range(count):
        x, y, z, word = struct.unpack_from("<4f", data, at)
        at += 16
        residual, mask = int(word) & 255, int(word) >> 8
        yield None if word < 0 else [x, y, z, residual * scale, mask]


with open(sys.argv[1], "rb") as file:
    data = file.read()
assert len(data) % BLOCK == 0, "whole blocks"
assert data[1] == 0x50, "no C3D file"
parameters = parameters_of(data, (data[0] - 1) * BLOCK)
points, analog, first, last = struct.unpack_from("<4H", data, 2)
scale, start = struct.unpack_from("<fH", data, 12)
(rate,) = struct.unpack_from("<f", data, 20)
point, trial = parameters["POINT"], parameters["TRIAL"]
begin, end = (
    trial[name][0] + 65536 * trial[name][1]
    for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD")
)
labels = labels_of(point)
assert point["USED"] == points == len(labels) and analog == 0
assert point["DATA_START"] == start and point["RATE"] == rate
assert point["SCALE"] == scale < 0, "points are floats"
assert first == min(begin, 65535) and last == min(end, 65535)
count = end - begin + 1
assert point["FRAMES"] == min(count, 65535)
if count >= 65535:
    assert point["LONG_FRAMES"] == count, "POINT:FRAMES has 16 bits"
at = (start - 1) * BLOCK
size = 16 * points
assert 0 <= len(data) - at - count * size < BLOCK
frames = [
    list(points_of(data, at + f * size, points, -scale)) for f in range(count)
]
json.dump(
    {
        "first": begin,
        "rate": rate,
        "scale": -scale,
        "labels": labels,
        "frames": frames,
        "parameters": parameters,
    },
    sys.stdout,
)
