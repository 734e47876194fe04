"""Reads a C3D file as c3d.org's user guide describes it and prints JSON.

Written for the tests, apart from the writer: parameters are found through
their pointers, and what header and parameters both say must agree.
"""

import json
import struct
import sys

BLOCK = 512


def value_of(data, at, order):
    kind, count = struct.unpack_from("bB", data, at)
    shape = list(data[at + 2 : at + 2 + count])
    at += 2 + count
    total = 1
    for side in shape:
        total *= side
    if kind == -1:
        text = data[at : at + total]
        if len(shape) < 2:
            return text.decode("utf-8")
        width = shape[0]
        return [
            text[i : i + width].decode("utf-8").rstrip(" ")
            for i in range(0, total, width)
        ]
    code = {1: "b", 2: "H", 4: "f"}[kind]
    numbers = list(struct.unpack_from(order + str(total) + code, data, at))
    return numbers if shape else numbers[0]


def parameters_of(data, first_block):
    start = (first_block - 1) * BLOCK
    blocks, processor = data[start + 2], data[start + 3]
    order = {84: "<", 86: ">"}[processor]
    groups, values = {}, {}
    at = start + 4
    end = start + blocks * BLOCK
    while at < end:
        length, group = struct.unpack_from("bb", data, at)
        if length == 0:
            break
        length = abs(length)
        name = data[at + 2 : at + 2 + length].decode("ascii")
        here = at + 2 + length
        (step,) = struct.unpack_from(order + "H", data, here)
        if group < 0:
            groups[-group] = name
        else:
            values[(group, name)] = value_of(data, here + 2, order)
        if step == 0:
            break
        at = here + step
    result = {name: {} for name in groups.values()}
    for (group, name), value in values.items():
        result[groups[group]][name] = value
    return order, result


def labels_of(point):
    labels = list(point["LABELS"])
    part = 2
    while "LABELS%d" % part in point:
        labels += point["LABELS%d" % part]
        part += 1
    return labels


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    assert len(data) % BLOCK == 0, "whole blocks"
    assert data[1] == 0x50, "no C3D file"
    order, parameters = parameters_of(data, data[0])
    points, analog, first, last = struct.unpack_from(order + "4H", data, 2)
    scale, start = struct.unpack_from(order + "fH", data, 12)
    (rate,) = struct.unpack_from(order + "f", data, 20)
    point = parameters["POINT"]
    trial = parameters["TRIAL"]
    begin, end = (
        trial[name][0] + 65536 * trial[name][1]
        for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD")
    )
    labels = labels_of(point)
    assert point["USED"] == points == len(labels) and analog == 0
    assert point["DATA_START"] == start
    assert point["SCALE"] == scale < 0, "points are floats"
    assert point["RATE"] == rate
    assert first == min(begin, 65535) and last == min(end, 65535)
    count = end - begin + 1
    assert point["FRAMES"] == min(count, 65535)
    if count >= 65535:
        assert point["LONG_FRAMES"] == count, "a word says 65535 or more"
    at = (start - 1) * BLOCK
    frames = []
    for _ in range(begin, end + 1):
        row = []
        for _ in range(points):
            x, y, z, word = struct.unpack_from(order + "4f", data, at)
            at += 16
            word = int(word)
            if word < 0:
                row.append(None)
            else:
                row.append([x, y, z, (word & 255) * -scale, word >> 8])
        frames.append(row)
    assert 0 <= len(data) - at < BLOCK
    return {
        "first": begin,
        "rate": rate,
        "scale": -scale,
        "labels": labels,
        "frames": frames,
        "parameters": parameters,
    }


if __name__ == "__main__":
    json.dump(read(sys.argv[1]), sys.stdout)
