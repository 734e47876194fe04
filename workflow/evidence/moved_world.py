"""A Pose2Sim calibration in a world whose origin lies elsewhere.

    python3 moved_world.py CALIBRATION.toml X Y Z > MOVED.toml

X, Y, Z: where the new origin lies in the old world, in its unit. Cameras stay
where they are: x_cam = R x + t = R (x - o) + (t + R o).
"""
import math
import re
import sys


def rotation(vector):
  """Matrix of a rotation vector [rad] (Rodrigues)."""
  angle = math.sqrt(sum(v * v for v in vector))
  identity = [[float(r == c) for c in range(3)] for r in range(3)]
  if angle == 0.0:
    return identity
  x, y, z = (v / angle for v in vector)
  cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
  squared = [[sum(cross[r][k] * cross[k][c] for k in range(3)) for c in range(3)]
             for r in range(3)]
  return [[identity[r][c] + math.sin(angle) * cross[r][c] +
           (1.0 - math.cos(angle)) * squared[r][c] for c in range(3)]
          for r in range(3)]


def numbers(line):
  return [float(n) for n in re.search(r"\[(.*)\]", line).group(1).split(",") if n.strip()]


origin = [float(v) for v in sys.argv[2:5]]
matrix = None
with open(sys.argv[1]) as file:
  for line in file:
    if re.match(r"\s*rotation\s*=", line):
      matrix = rotation(numbers(line))
    if re.match(r"\s*translation\s*=", line):
      moved = [t + sum(matrix[r][k] * origin[k] for k in range(3))
               for r, t in enumerate(numbers(line))]
      line = "translation = [ %r, %r, %r,]\n" % tuple(moved)
    sys.stdout.write(line)
