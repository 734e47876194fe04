"""Converts arrays of detections to JSON: fast, and so that numbers read back exactly."""

from __future__ import annotations

import json

import numpy as np


def array_lines(views, arrays, first_frame=0):
    """Yields one line per frame. arrays: one per view, [frames, people, joints, 3] of
    x, y [px] and confidence, NaN for a missing joint; their lengths may differ."""
    keys = [json.dumps(view).encode() + b":[" for view in views]
    count = max(len(array) for array in arrays)
    at_once = 1000  # frames per step, to bound the memory of their text
    for begin in range(0, count, at_once):
        texts = [_people_by_frame(array[begin : begin + at_once]) for array in arrays]
        for f in range(min(at_once, count - begin)):
            people = [
                key + b",".join(text[f] if f < len(text) else ()) + b"]"
                for key, text in zip(keys, texts)
            ]
            yield b'{"frame":%d,"views":{%s}}\n' % (
                first_frame + begin + f,
                b",".join(people),
            )


def _people_by_frame(array):
    """Texts of the people of each frame, without people that have no joint."""
    seen = np.isfinite(array).all(axis=3).any(axis=2)
    texts = [[] for _ in range(len(array))]
    for f, text in zip(np.nonzero(seen)[0].tolist(), _people(array[seen])):
        texts[f].append(text)
    return texts


# Decimals, chosen so that no number has more than 19 digits, beyond which JSON parsers
# are slow. For numbers from the lower bound on, the truncated text is nearer to the
# number than to any other double.
_PX_DIGITS, _PX_LEAST, _PX_MOST = 15, 16.0, 1e4
_SCORE_DIGITS, _SCORE_LEAST, _SCORE_MOST = 18, 2.0**-6, 10.0
_ROW = b"[" + (b"    ." + b" " * _PX_DIGITS + b",") * 2 + b" ." + b" " * _SCORE_DIGITS
_ROW = np.frombuffer(_ROW + b"],", dtype=np.uint8)
_NONE = np.frombuffer(b"null".ljust(len(_ROW) - 1) + b",", dtype=np.uint8)


def _people(points):
    """Texts of people [people, joints, 3]. Python's own conversion is exact but slow:
    numbers of the usual range are converted together, in cells of fixed width."""
    there = np.isfinite(points).all(axis=2, keepdims=True)
    px, score = points[..., :2], points[..., 2:]
    usual = ((px >= _PX_LEAST) & (px < _PX_MOST)).all(axis=2, keepdims=True)
    usual &= (score == 0) | ((score >= _SCORE_LEAST) & (score < _SCORE_MOST))
    usual = (usual | ~there)[..., 0].all(axis=1)
    cells = np.empty((*points.shape[:2], len(_ROW)), dtype=np.uint8)
    cells[:] = _ROW
    counted = np.where(there & usual[:, None, None], points, 0.0)
    at = 1
    for axis in range(2):
        _put_digits(counted[..., axis], 4, _PX_DIGITS, cells[..., at:])
        at += 4 + 1 + _PX_DIGITS + 1
    _put_digits(counted[..., 2], 1, _SCORE_DIGITS, cells[..., at:])
    cells[~there[..., 0]] = _NONE
    cells[:, -1, -1] = ord("]")
    for p, is_usual in enumerate(usual.tolist()):
        if is_usual:
            yield b'{"joints":[' + cells[p].tobytes() + b"}"
        else:
            joints = [
                joint if is_there else None
                for joint, is_there in zip(points[p].tolist(), there[p, :, 0].tolist())
            ]
            yield json.dumps({"joints": joints}, separators=(",", ":")).encode()


def _put_digits(numbers, before, behind, cells):
    """Writes numbers with `before` and `behind` digits around the point."""
    whole = np.floor(numbers)
    rest = whole.astype(np.uint64)
    for place in reversed(range(before)):
        digit = (rest % 10).astype(np.uint8) + ord("0")
        is_last = place == before - 1
        cells[..., place] = digit if is_last else np.where(rest > 0, digit, ord(" "))
        rest //= 10
    bits = 58  # enough for the fraction of a usual number; ten times it fits 64 bits
    fraction = ((numbers - whole) * 2.0**bits).astype(np.uint64)
    for place in range(before + 1, before + 1 + behind):
        fraction *= 10
        cells[..., place] = (fraction >> bits).astype(np.uint8) + ord("0")
        fraction &= (1 << bits) - 1
