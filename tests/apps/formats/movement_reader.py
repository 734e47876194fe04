"""Opens a netCDF file with xarray as `movement` does and prints JSON.

Checks the dimensions, variables and attributes that `movement` requires of a
data set of poses.
"""

import json
import math
import sys

import xarray

data = xarray.load_dataset(sys.argv[1], engine="scipy")
assert data.attrs["ds_type"] == "poses"
assert data.position.dims == ("time", "space", "keypoints", "individuals")
assert data.confidence.dims == ("time", "keypoints", "individuals")
assert data.space.values.tolist() == ["x", "y", "z"]
assert set(data.coords) >= {"time", "space", "keypoints", "individuals"}


def plain(values):
    if isinstance(values, list):
        return [plain(value) for value in values]
    return None if isinstance(values, float) and math.isnan(values) else values


json.dump(
    {
        "fps": float(data.attrs["fps"]),
        "time_unit": data.attrs["time_unit"],
        "individuals": data.individuals.values.tolist(),
        "keypoints": data.keypoints.values.tolist(),
        "time": plain(data.time.values.tolist()),
        "frame": plain(data.frame.values.tolist()),
        "identity": plain(data.identity.values.tolist()),
        "position": plain(data.position.values.tolist()),
        "confidence": plain(data.confidence.values.tolist()),
        "status": plain(data.status.values.tolist()),
        "sigma": plain(data.position_sigma.values.tolist()),
        # What a user does: one joint of one individual, by name.
        "chosen": plain(
            data.position.sel(individuals="Anna", keypoints="r_knee")
            .isel(time=10)
            .values.tolist()
        ),
    },
    sys.stdout,
)
