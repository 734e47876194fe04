"""Expected results of the filters, by SciPy, statsmodels and cvxopt, or by NumPy's
dense algebra where no package has the method: prints tests/solvers/filters/reference.json.

Debian: python3-scipy 1.10.1, python3-statsmodels 0.13.5, python3-cvxopt 1.3.0.
"""
import json
import math

import cvxopt
import numpy as np
from scipy import interpolate, optimize, signal
from statsmodels.nonparametric.smoothers_lowess import lowess
from statsmodels.tsa.filters.hp_filter import hpfilter

RATE = 25.0
CASES = {}
RULES = {}


def case(name, times, values, expected, sampled=None):
    CASES[name] = {
        "times": list(map(float, times)),
        "values": np.reshape(values, (len(times), -1)).tolist(),
        "sampled": [1] * len(times) if sampled is None else list(map(int, sampled)),
        "expected": np.reshape(np.asarray(expected, float), (len(times), -1)).tolist(),
    }


def noise(count, state=1):
    """Uniform noise of a linear congruential generator, -1 .. 1."""
    out = []
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        out.append(2.0 * state / 2**31 - 1.0)
    return np.array(out)


def wave(times, state=1):
    return np.sin(2.0 * times) + 0.4 * np.sin(7.0 * times) + 0.05 * noise(len(times), state)


n = 60
even = np.arange(n) / RATE
uneven = np.sort(even + 0.012 * np.sin(1.7 * np.arange(n)))
y = wave(even)
z = wave(uneven, 7)
sampled = np.array([k not in (20, 21, 22, 40) for k in range(n)])
kinks = np.interp(even, [0.0, 0.7, 1.1, 2.4], [0.0, 1.0, -0.5, 0.2]) + 0.05 * noise(n, 3)
outliers = y + 1.5 * (np.arange(n) % 13 == 5)


# ---- Whittaker-Henderson ----

def frames(times):
    return (times - times[0]) / (times[-1] - times[0]) * (len(times) - 1)


def differences(times, order):
    """Rows: order! times the divided difference, by Newton's recursion, times the root
    of its mean interval."""
    x = frames(times)
    table = np.eye(len(x))
    for k in range(1, order + 1):
        table = (table[1:] - table[:-1]) / (x[k:] - x[:-k])[:, None] * k
    span = (x[order:] - x[:-order]) / order
    return np.sqrt(span)[:, None] * table


def whittaker(order, times, weights, penalty):
    D = differences(times, order)
    return np.linalg.solve(np.diag(weights) + penalty * D.T @ D, np.diag(weights))


def gcv(hat, values, kept):
    rest = (values - hat @ values)[kept]
    free = kept.sum() - np.trace(hat)
    return kept.sum() * rest @ rest / free**2


def least_gcv(hat_of, values, kept, low, high):
    grid = np.linspace(low, high, 200)
    scores = [gcv(hat_of(10.0**g), values, kept) for g in grid]
    best = int(np.argmin(scores))
    found = optimize.minimize_scalar(
        lambda g: gcv(hat_of(10.0**g), values, kept),
        bounds=(grid[max(best - 1, 0)], grid[min(best + 1, 199)]),
        method="bounded", options={"xatol": 1e-10})
    return 10.0**found.x


ones = np.ones(n)
case("whittaker_hp", even, y, hpfilter(y, 40.0)[1])
case("whittaker_2", even, y, whittaker(2, even, ones, 40.0) @ y)
case("whittaker_3", even, y, whittaker(3, even, ones, 300.0) @ y)
case("whittaker_2_uneven", uneven, z, whittaker(2, uneven, ones, 40.0) @ z)
case("whittaker_3_uneven", uneven, z, whittaker(3, uneven, ones, 300.0) @ z)
filled = np.where(sampled, y, 0.0)
case("whittaker_2_gap", even, filled,
     whittaker(2, even, sampled.astype(float), 40.0) @ filled, sampled)
best = least_gcv(lambda p: whittaker(3, even, ones, p), y, ones > 0, -2.0, 8.0)
case("whittaker_3_gcv", even, y, whittaker(3, even, ones, best) @ y)
RULES["whittaker_3_gcv_lambda"] = best
best = least_gcv(lambda p: whittaker(2, even, sampled.astype(float), p), filled,
                 sampled, -2.0, 8.0)
case("whittaker_2_gap_gcv", even, filled,
     whittaker(2, even, sampled.astype(float), best) @ filled, sampled)


# ---- Quintic spline: the reduced basis of natural splines ----

def eliminate(matrix, right):
    """Gauss with pivoting in extended precision: the basis is ill-conditioned."""
    a = np.hstack([matrix, right]).astype(np.longdouble)
    size = len(matrix)
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(a[k:, k])))
        a[[k, pivot]] = a[[pivot, k]]
        a[k + 1:] -= np.outer(a[k + 1:, k] / a[k, k], a[k])
    for k in reversed(range(size)):
        a[k, size:] -= a[k, k + 1:size] @ a[k + 1:size, size:]
        a[k, size:] /= a[k, k]
    return a[:, size:]


def quintic(times, kept, penalty, at):
    """The hat matrix of f(t) = sum of c_j |t - t_j|^5 and a parabola, where the
    coefficients c are orthogonal to parabolas: f is a natural spline, and the integral
    of f''' squared is -240 c' E c."""
    x = np.asarray(times, np.longdouble)[kept]
    step = (x[-1] - x[0]) / (len(x) - 1)
    x = (x - x[0]) / step
    to = (np.asarray(at, np.longdouble) - np.asarray(times, np.longdouble)[kept][0]) / step
    # Centred and scaled to -1 .. 1, which only changes the units.
    middle, half = x.mean(), (x[-1] - x[0]) / 2
    unit, unit_to = (x - middle) / half, (to - middle) / half
    size = len(x)
    E = np.abs(unit[:, None] - unit[None, :])**5
    T = np.vander(unit, 3, increasing=True)
    system = np.zeros((size + 3, size + 3), np.longdouble)
    system[:size, :size] = E - 240.0 * penalty / half**5 * np.eye(size)
    system[:size, size:] = T
    system[size:, :size] = T.T
    solution = eliminate(system, np.vstack([np.eye(size), np.zeros((3, size))]))
    basis = np.hstack([np.abs(unit_to[:, None] - unit[None, :])**5,
                       np.vander(unit_to, 3, increasing=True)])
    return (basis @ solution).astype(float)


case("quintic", even, y, quintic(even, ones > 0, 300.0, even) @ y)
case("quintic_uneven", uneven, z, quintic(uneven, ones > 0, 300.0, uneven) @ z)
case("quintic_gap", even, filled, quintic(even, sampled, 300.0, even) @ filled[sampled],
     sampled)
best = least_gcv(lambda p: quintic(even, ones > 0, p, even), y, ones > 0, -2.0, 6.0)
case("quintic_gcv", even, y, quintic(even, ones > 0, best, even) @ y)
RULES["quintic_gcv_lambda"] = best
case("cubic", even, y,
     interpolate.make_smoothing_spline(np.arange(n), y, lam=40.0)(np.arange(n)))


# ---- LOESS ----

def loess(times, values, neighbours, degree, iterations, at):
    values = np.reshape(values, (len(times), -1))
    robust = np.ones(len(times))

    def fit(places):
        out = []
        for t in places:
            distance = np.abs(times - t)
            near = np.argsort(distance, kind="stable")[:neighbours]
            w = np.clip(1 - (distance[near] / distance[near].max())**3, 0, None)**3
            w = np.sqrt(w * robust[near])
            A = np.vander(times[near] - t, degree + 1, increasing=True)
            out.append(np.linalg.lstsq(w[:, None] * A, w[:, None] * values[near],
                                       rcond=None)[0][0])
        return np.array(out)

    for _ in range(iterations):
        r = np.linalg.norm(values - fit(times), axis=1)
        robust = np.clip(1 - (r / (6 * np.median(r)))**2, 0, None)**2
    return fit(at)


case("lowess", even, y, lowess(y, even, frac=11.5 / n, it=0)[:, 1])
case("lowess_robust", even, outliers, lowess(outliers, even, frac=15.5 / n, it=3)[:, 1])
case("lowess_uneven", uneven, z, lowess(z, uneven, frac=12.5 / n, it=2)[:, 1])
case("loess_2", even, y, loess(even, y, 13, 2, 0, even))
case("loess_2_robust", uneven, outliers, loess(uneven, outliers, 15, 2, 2, uneven))
both = np.column_stack([outliers, y])
case("loess_1_two_columns", even, both, loess(even, both, 11, 1, 3, even))
case("loess_2_gap", even, filled,
     loess(even[sampled], filled[sampled], 13, 2, 1, even), sampled)


# ---- l1 trend filtering: the dual by cvxopt, then an exact solution of its KKT system ----

def trend(times, values, penalty):
    x = frames(times)
    D = np.zeros((len(x) - 2, len(x)))
    for i in range(len(x) - 2):
        before, behind = 1 / (x[i + 1] - x[i]), 1 / (x[i + 2] - x[i + 1])
        D[i, i:i + 3] = before, -before - behind, behind
    m = len(D)
    cvxopt.solvers.options.update(show_progress=False, abstol=1e-12, reltol=1e-12,
                                  feastol=1e-12)
    u = np.ravel(cvxopt.solvers.qp(
        cvxopt.matrix(D @ D.T), cvxopt.matrix(-D @ values),
        cvxopt.matrix(np.vstack([np.eye(m), -np.eye(m)])),
        cvxopt.matrix(np.full(2 * m, penalty)))["x"])
    bound = np.abs(np.abs(u) - penalty) < 1e-5 * penalty
    u[bound] = np.sign(u[bound]) * penalty
    free = ~bound
    u[free] = np.linalg.solve(D[free] @ D[free].T,
                              D[free] @ (values - D[bound].T @ u[bound]))
    result = values - D.T @ u
    assert np.all(np.abs(u) <= penalty * (1 + 1e-12)), "feasible"
    assert np.all(u[bound] * (D @ result)[bound] >= 0), "signs"
    assert np.all(np.abs((D @ result)[free]) < 1e-12), "straight"
    return result


case("trend", even, kinks, trend(even, kinks, 0.2))
case("trend_wave", even, y, trend(even, y, 0.02))
case("trend_uneven", uneven, z, trend(uneven, z, 0.1))


# ---- Recursive filters ----

def one_euro(times, values, min_cutoff, beta):
    def share(step, cutoff):
        return 1.0 / (1.0 + 1.0 / (2 * np.pi * cutoff * step))
    out, speed = [values[0]], 0.0
    for k in range(1, len(values)):
        step = times[k] - times[k - 1]
        speed += share(step, 1.0) * ((values[k] - out[-1]) / step - speed)
        out.append(out[-1] + share(step, min_cutoff + beta * abs(speed)) * (values[k] - out[-1]))
    return np.array(out)


forwards = one_euro(uneven, z, 2.0, 1.5)
case("one_euro_zero_phase", uneven, z,
     one_euro(uneven[-1] - uneven[::-1], forwards[::-1], 2.0, 1.5)[::-1])


def butterworth(values, cutoff, rate=RATE, order=2):
    half = (math.sqrt(2) - 1)**(0.5 / order)
    corrected = np.arctan(np.tan(np.pi * cutoff / rate) / half) * rate / np.pi
    b, a = signal.butter(order, corrected, fs=rate)
    return signal.filtfilt(b, a, values, axis=0)


def damped(values, cutoff, order, passes):
    """All poles at one analogue frequency, by SciPy's bilinear transform."""
    w = 2 * RATE * np.tan(np.pi * cutoff / RATE)
    w /= math.sqrt(2**(1 / (passes * order)) - 1)
    b, a = signal.bilinear([w**order], np.poly(np.full(order, -w)), RATE)
    return signal.filtfilt(b, a, values)


case("butterworth", even, y, butterworth(y, 4.0))
steps = butterworth(np.diff(y), 4.0)
sums = np.concatenate([[0.0], np.cumsum(steps)])
case("butterworth_speed", even, y, sums + y.mean() - sums.mean())
case("critically_damped_2", even, y, damped(y, 4.0, 2, 2))
case("critically_damped_3", even, y, damped(y, 4.0, 3, 2))
case("critically_damped_a_pass", even, y, damped(y, 4.0, 2, 1))


# ---- Rules for a cut-off [Hz] ----

m = 200
t = np.arange(m) / RATE
moves = np.column_stack([wave(t, 11), 0.3 * np.cos(3.0 * t) + 0.02 * noise(m, 5),
                         0.2 * t + 0.01 * noise(m, 9)])


def residuals(values, rate=RATE):
    return np.array([np.sqrt(np.sum((values - butterworth(values, 0.01 * k * rate))**2)
                             / len(values)) for k in range(1, 46)])


def winter(values):
    r, f = residuals(values), 0.01 * np.arange(1, 46) * RATE
    noise_level = np.polyfit(f[24:], r[24:], 1)[1]
    k = int(np.argmax(r <= noise_level))
    if r[k] > noise_level:
        return f[-1]
    return f[0] if k == 0 else np.interp(-noise_level, [-r[k - 1], -r[k]], [f[k - 1], f[k]])


def jackson(values):
    bend = np.diff(residuals(values), 2)
    top = int(np.argmax(bend))
    below = np.nonzero(bend[top:] <= 0.05 * bend[top])[0]
    return 0.01 * RATE * (top + below[0] + 2)


def challis(values):
    def score(cutoff):
        rest = values - butterworth(values, cutoff)
        r = sum(np.correlate(c, c, "full") for c in rest.T)
        return np.abs(r).sum() / r.max()
    candidates = 0.005 * np.arange(2, 51) * RATE
    return candidates[int(np.argmin([score(f) for f in candidates]))]


def yu(values):
    first = 0.071 * RATE - 0.00003 * RATE**2
    rest = values - butterworth(values, first)
    e = 100 * np.sqrt(np.sum(rest**2) / np.sum((values - values.mean(axis=0))**2))
    return 0.06 * RATE - 0.000022 * RATE**2 + 5.95 / e


def gcv_rule(values):
    scores = []
    for k, r in enumerate(residuals(values), 1):
        half = (math.sqrt(2) - 1)**0.25
        ratio = np.tan(np.pi * (np.arange(500) + 0.5) / 1000) / (
            np.tan(np.pi * 0.01 * k) / half)
        scores.append((r / (1 - np.mean(1 / (1 + ratio**4))))**2)
    return 0.01 * RATE * (1 + int(np.argmin(scores)))


def power(values, share):
    length = 2
    while length < 2 * len(values):
        length *= 2
    f, p = signal.periodogram(values, RATE, window="hann", nfft=length,
                              detrend="linear", axis=0, scaling="spectrum")
    p = p.sum(axis=1)
    p[1:-1] /= 2  # two-sided bins
    total = np.cumsum(p)
    k = int(np.argmax(total >= share * total[-1]))
    return f[k] - (total[k] - share * total[-1]) / p[k] * f[1]


for column, values in enumerate([moves[:, [0]], moves[:, [1]], moves[:, [2]], moves]):
    where = "xyz"[column] if column < 3 else "all"
    RULES[where] = {
        "winter": winter(values), "challis": challis(values), "yu": yu(values),
        "jackson": jackson(values), "gcv": gcv_rule(values),
        "power95": power(values, 0.95), "power99": power(values, 0.99)}
    RULES[where] = {k: float(np.clip(v, 0.01 * RATE, 0.45 * RATE))
                    for k, v in RULES[where].items()}

print(json.dumps({"rate": RATE, "cases": CASES, "moves": moves.tolist(), "rules": RULES},
                 indent=None, separators=(",", ":")).replace('},"', '},\n"'))
