// Series for the timelines.
import { LENGTH, MISSING, NO_VALUE, PALETTE, SPEED, colourOf, data, frameCount, nameOf, times, viewCount } from './data.js';

function jointDistance(result, p, q, j) {
  const J = result.joints.length, a = (p * J + j) * 3, b = (q * J + j) * 3, xyz = result.xyz;
  if ((result.status[p * J + j] & 3) === MISSING || (result.status[q * J + j] & 3) === MISSING) return NaN;
  return Math.hypot(xyz[a] - xyz[b], xyz[a + 1] - xyz[b + 1], xyz[a + 2] - xyz[b + 2]);
}

export function perPerson(result, valueOf) {
  return result.ids.map((id, person) => {
    const values = new Float32Array(frameCount).fill(NaN);
    result.ofPerson[person].forEach((p, i) => { values[result.frame[p]] = valueOf(p, i, result.ofPerson[person]); });
    return { name: nameOf(result, person), colour: () => colourOf(result, person), values: values, thin: result.index > 0, source: result.label };
  });
}

export function speedOf(result) {
  return (p, i, list) => {
    if (i === 0) return NaN;
    const q = list[i - 1], dt = times[result.frame[p]] - times[result.frame[q]];
    if (!(dt > 0) || dt > 0.25) return NaN;
    let sum = 0, n = 0;
    for (let j = 0; j < result.joints.length; ++j) {
      const distance = jointDistance(result, p, q, j);
      if (distance === distance) { sum += distance; ++n; }
    }
    return n ? SPEED.per * sum / n / dt : NaN;
  };
}

export function boneLengthOf(result, bone) {
  const J = result.joints.length, [a, b] = bone;
  return (p) => {
    if ((result.status[p * J + a] & 3) === MISSING || (result.status[p * J + b] & 3) === MISSING) return NaN;
    const x = (p * J + a) * 3, y = (p * J + b) * 3, xyz = result.xyz;
    return LENGTH.per * Math.hypot(xyz[x] - xyz[y], xyz[x + 1] - xyz[y + 1], xyz[x + 2] - xyz[y + 2]);
  };
}

export function meanViews(result, p) {
  const J = result.joints.length;
  let sum = 0, n = 0;
  for (let j = 0; j < J; ++j) {
    if ((result.status[p * J + j] & 3) !== MISSING) { sum += result.status[p * J + j] >> 2; ++n; }
  }
  return n ? sum / n : 0;
}

export function residualSeries(result) {
  return data.cameras.map((camera, v) => {
    const values = new Float32Array(frameCount).fill(NaN);
    for (let f = 0; f < frameCount; ++f) {
      let sum = 0, n = 0;
      for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
        const value = result.residual[p * viewCount + v];
        if (value !== NO_VALUE) { sum += value * 0.1; ++n; }
      }
      if (n) values[f] = sum / n;
    }
    return { name: camera.view, colour: () => PALETTE[v % PALETTE.length], values: values, thin: false };
  });
}
