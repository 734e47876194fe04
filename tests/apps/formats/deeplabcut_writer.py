"""Writes two views as DeepLabCut's HDF5 with pandas, of one and of two animals.

Bodypart n of individual t in frame f of view v stands at
x = 1 + 100 v + 10 t + n + f / 8, y = 2 x (a point at (0, 0) is none); its likelihood is 1 / (1 + n). Individual 1
is there from frame 2 on only.
"""

import sys

import numpy as np
import pandas as pd

parts = ["snout", "left_ear", "tail_base"]
coords = ["x", "y", "likelihood"]
for name, individuals in (("one", [None]), ("two", ["a", "b"])):
    for view in range(2):
        columns, numbers = [], []
        for t, individual in enumerate(individuals):
            for n, part in enumerate(parts):
                x = 1 + 100 * view + 10 * t + n + np.arange(5) / 8
                likelihood = np.full(5, 1 / (1 + n))
                for coord, values in zip(coords, (x, 2 * x, likelihood)):
                    if t == 1:
                        values = np.where(np.arange(5) < 2, np.nan, values)
                    who = [] if individual is None else [individual]
                    columns.append(("DLC_net", *who, part, coord))
                    numbers.append(values)
        levels = ["scorer", "individuals", "bodyparts", "coords"]
        if individuals == [None]:
            levels.remove("individuals")
        frame = pd.DataFrame(
            np.array(numbers).T,
            columns=pd.MultiIndex.from_tuples(columns, names=levels),
        )
        frame.to_hdf(
            "%s/%s/cam%d.h5" % (sys.argv[1], name, view),
            key="df_with_missing",
            format="table",
            mode="w",
        )
