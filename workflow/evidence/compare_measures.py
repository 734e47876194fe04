"""What the page of `compare` shows of a folder that the command wrote.

    python3 compare_measures.py FOLDER [ERROR] > FILE.json

rows: a strategy each, a measure with its difference to the baseline. at: by
names of strategy and measure the value alone. tuned: each parameter's values on
the two halves. lags: windows against the batch. agreement: rank correlation
(Spearman) of held-out error with the measure ERROR (mpjpe_mm), over strategies.
"""
import json
import pathlib
import sys

SHOWN = ["held_out_mean_px", "held_out_common_px", "acceleration_m_s2",
         "lag_to_batch_ms", "mpjpe_mm", "mpjpe_bias_removed_mm", "pcp_percent",
         "truth_covered_percent", "held_out_covered_percent"]
MEASURES = SHOWN + ["held_out_median_px", "held_out_head_px"]


def ranks(values):
  """From 0 on; those that are equal share the mean."""
  return [sum(v < value for v in values) + 0.5 * (values.count(value) - 1)
          for value in values]


def rank_correlation(xs, ys):
  a, b = ranks(xs), ranks(ys)
  mean = (len(a) - 1) / 2
  product = sum((x - mean) * (y - mean) for x, y in zip(a, b))
  squares = [sum((x - mean)**2 for x in c) for c in (a, b)]
  return product / (squares[0] * squares[1])**0.5


def row_of(strategy):
  row = {"name": strategy["name"], "title": strategy["title"]}
  for name in SHOWN:
    measure = strategy["measures"].get(name)
    if measure is None:
      continue
    interval = measure["difference_interval"]
    row[name] = {"value": measure["value"], "verdict": measure["verdict"],
                 "difference": measure["difference_to_baseline"],
                 "low": interval["low"], "high": interval["high"]}
  return row


def agreement(at, held_out, error):
  if any(one.get(error) is None for one in at.values()):
    return None
  return rank_correlation([one[held_out] for one in at.values()],
                          [one[error] for one in at.values()])


def main():
  folder = pathlib.Path(sys.argv[1])
  error = sys.argv[2] if len(sys.argv) > 2 else "mpjpe_mm"
  compared = json.loads((folder / "compare.json").read_text())
  times = [one for one in json.loads((folder / "runtime.json").read_text())
           if "tuning_cpu_s" in one]
  # Some refuse a take, such as one whose time is not uniform.
  strategies = [one for one in compared["strategies"] if "measures" in one]
  at = {one["name"]: {name: one["measures"][name]["value"] for name in MEASURES
                      if name in one["measures"]} for one in strategies}
  tuned = {one["name"]: {key: [half[key] for half in one["parameters"]]
                         for key in one["parameters"][0]} for one in strategies}
  json.dump({"rows": [row_of(one) for one in strategies], "at": at,
             "tuned": tuned, "lags": compared["lag_sweep"],
             "agreement": {name: agreement(at, f"held_out_{name}_px", error)
                           for name in ("common", "mean")},
             "cpu_us": {one["name"]: one["cpu_us_per_person_frame"]
                        for one in times},
             "tuning_s": sum(one["tuning_cpu_s"] for one in times)},
            sys.stdout)


if __name__ == "__main__":
  main()
