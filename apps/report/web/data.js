// The data of the page: results, detections, their people and colours.

export const data = JSON.parse(document.getElementById('data').textContent);
export const byId = (id) => document.getElementById(id);

export function decode(text, Type) {
  const raw = atob(text || '');
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  return new Type(bytes.buffer);
}

export const OBSERVED = 2, INFERRED = 1, MISSING = 0;
export const NO_VALUE = 65535, NO_WEIGHT = 255, NO_ANGLE = -32768;
// Most robust losses never give a weight of exactly zero, so a joint counts as
// rejected below a tenth (20 of 200).
export const REJECTED = 20;
export const frameNumbers = decode(data.frames, Float64Array);
export const times = decode(data.times, Float64Array);
export const frameCount = frameNumbers.length;
export const viewCount = data.detections ? data.cameras.length : 0;
// Okabe and Ito's colours except yellow and black, each of which is invisible in
// one of the themes, plus the two colours that differ most from the others for
// every type of colour vision.
export const PALETTE = ['#0072b2', '#e69f00', '#009e73', '#d55e00', '#56b4e9', '#cc79a7', '#8833ff', '#774422'];

// Lengths on the page are scaled to the size of people: one metre on the page is
// data.metre in the world. Units for display:
const metre = data.metre;
const displayUnit = (unit, perMetre) => ({ unit: unit, per: perMetre * metre });
export const LENGTH = metre > 0.3 ? displayUnit('cm', 100) : metre > 0.003 ? displayUnit('mm', 1e3) : displayUnit('\u00b5m', 1e6);
export const SPEED = metre > 0.03 ? displayUnit('m/s', 1) : displayUnit('mm/s', 1e3);

function loadResult(source, index) {
  const result = {
    index: index, label: source.label, truth: source.role === 'truth',
    ids: source.ids, colours: source.colours, joints: source.skeleton.joints, bones: source.skeleton.bones,
    frame: decode(source.frame, Uint32Array), person: decode(source.person, Uint16Array),
    status: decode(source.status, Uint8Array),
    residual: source.residual ? decode(source.residual, Uint16Array) : null,
    difference: source.difference ? decode(source.difference, Uint16Array) : null,
    match: source.match ? decode(source.match, Int16Array) : null,
    weight: source.weight ? decode(source.weight, Uint8Array) : null,
    covariance: source.covariance ? decode(source.covariance, Int16Array) : null,
    rootQuantum: source.rootQuantum, visible: true,
    names: source.names || {}, edits: source.edits || [], lines: source.identityLines || [],
    angles: source.angles || null
  };
  // Joints without a bone are drawn as dots.
  result.bare = result.joints.map((name, j) => j).filter((j) => !result.bones.some((bone) => bone.includes(j)));
  const root = decode(source.root, Int32Array), offset = decode(source.joints, Int16Array);
  const count = result.frame.length, J = result.joints.length;
  result.xyz = new Float32Array(count * J * 3);
  for (let p = 0; p < count; ++p) {
    for (let i = 0; i < J * 3; ++i) {
      result.xyz[p * J * 3 + i] = root[p * 3 + i % 3] * source.rootQuantum + offset[p * J * 3 + i] * source.quantum;
    }
  }
  // The poses of frame f have the indices start[f] to start[f + 1] - 1.
  result.start = new Uint32Array(frameCount + 1);
  for (let p = 0; p < count; ++p) result.start[result.frame[p] + 1]++;
  for (let f = 0; f < frameCount; ++f) result.start[f + 1] += result.start[f];
  // Extras are stored for some poses only.
  result.extra = new Int32Array(count);
  let stored = 0;
  for (let p = 0; p < count; ++p) {
    result.extra[p] = result.frame[p] % data.extrasStride === 0 ? stored++ : -1;
  }
  result.ofPerson = result.ids.map(() => []);
  for (let p = 0; p < count; ++p) result.ofPerson[result.person[p]].push(p);
  return result;
}

export const results = data.results.map(loadResult);

function loadDetections(source) {
  if (!source) return null;
  const counts = decode(source.counts, Uint16Array);
  const start = new Uint32Array(counts.length + 1);
  for (let i = 0; i < counts.length; ++i) start[i + 1] = start[i] + counts[i];
  return {
    joints: source.skeleton.joints, bones: source.skeleton.bones, quantum: source.quantum, start: start,
    xy: decode(source.xy, Uint16Array), confidence: decode(source.confidence, Uint8Array)
  };
}
export const detections = loadDetections(data.detections);

export function colourOf(result, person) {
  if (result.truth) return dark() ? '#d5dce5' : '#333b46';
  return PALETTE[result.colours[person] % PALETTE.length];
}

export function nameOf(result, person) {
  const id = result.ids[person];
  return (result.truth ? 'truth ' : '') + (Object.prototype.hasOwnProperty.call(result.names, id) ? result.names[id] : id);
}

export function dark() { return document.documentElement.classList.contains('dark'); }

export function element(tag, properties, children) {
  const node = Object.assign(document.createElement(tag), properties || {});
  (children || []).forEach((child) => node.append(child));
  return node;
}

// The largest index whose entry is at most `value`; 0 if there is none.
export function lastAtMost(list, value) {
  let low = 0, high = list.length - 1;
  while (low < high) {
    const mid = (low + high + 1) >> 1;
    if (list[mid] <= value) low = mid; else high = mid - 1;
  }
  return low;
}
