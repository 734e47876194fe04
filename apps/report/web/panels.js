// The camera panels: detections and poses in each image.
import { INFERRED, MISSING, NO_WEIGHT, REJECTED, byId, colourOf, dark, data, detections, element, nameOf, results, viewCount } from './data.js';
import { drawPicture, openVideo } from './pictures.js';
import { onFrame, state } from './playback.js';

function lensLimit(k) {
  // First squared radius where the radial polynomial folds back.
  for (let s = 0; s < 25; s += 0.01) {
    if (1 + 3 * k[0] * s + 5 * k[1] * s * s + 7 * k[4] * s * s * s <= 0) return s;
  }
  return Infinity;
}

function fisheyeRadius(camera, angle) {
  // Image radius at an angle off the axis; null beyond the fold of the polynomial.
  const k = camera.distortion;
  const slope = (s) => 1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])));
  if (camera.limit === undefined) {
    camera.limit = Infinity;
    for (let a = 0; a < Math.PI / 2 && camera.limit === Infinity; a += 1e-3) if (slope(a * a) <= 0) camera.limit = a;
  }
  const s = angle * angle;
  return angle < camera.limit ? angle * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))) : null;
}

function project(camera, x, y, z) {
  const R = camera.R, t = camera.t, K = camera.K;
  const depth = R[6] * x + R[7] * y + R[8] * z + t[2];
  if (depth <= 1e-6) return null;
  let u = (R[0] * x + R[1] * y + R[2] * z + t[0]) / depth, v = (R[3] * x + R[4] * y + R[5] * z + t[1]) / depth;
  if (camera.model === 'opencv_fisheye') {
    const radius = Math.hypot(u, v), bent = fisheyeRadius(camera, Math.atan(radius));
    if (bent === null) return null;
    if (radius > 1e-9) {
      u *= bent / radius;
      v *= bent / radius;
    }
  }
  if (camera.model === 'opencv5') {
    const k = camera.distortion, s = u * u + v * v;
    if (camera.limit === undefined) camera.limit = lensLimit(k);
    if (s >= camera.limit) return null;
    const radial = 1 + s * (k[0] + s * (k[1] + s * k[4]));
    const du = u * radial + 2 * k[2] * u * v + k[3] * (s + 2 * u * u);
    v = v * radial + k[2] * (s + 2 * v * v) + 2 * k[3] * u * v;
    u = du;
  }
  return [K[0] * u + K[1] * v + K[2], K[4] * v + K[5]];
}

export const panels = [];
export function makePanels() {
  if (data.cameras.length === 0) return;
  byId('views').hidden = false;
  byId('view-legend').textContent = detections
    ? 'Thin lines: detections (circles: joints that were found; dashed: unmatched detections). Thick lines: 3D poses projected into the camera. '
      + 'Cross: joint that was rejected by the joints filter or that the robust loss weights by less than 0.1. Square: joint that the detector did not find. '
      + (results.some((r) => r.match && hasWeights(r)) ? '' : 'The tracks contain no matches: each person is paired with the nearest detection.')
    : 'The 3D poses as each camera would see them.';
  data.cameras.forEach((camera, v) => {
    const canvas = element('canvas');
    const width = camera.width || 2 * camera.K[2], height = camera.height || 2 * camera.K[5];
    const facts = element('span');
    byId('panels').append(element('figure', {}, [canvas, element('figcaption', {}, [element('b', { textContent: camera.view }), facts])]));
    const panel = { camera: camera, view: v, canvas: canvas, facts: facts, width: width, height: height, seen: true, pictures: new Map(), lacks: '' };
    panel.redraw = (f) => { if (panel.seen) drawPanel(panel, f); };
    panels.push(panel);
  });
  // When playback stops, videos seek the exact image.
  onFrame((f) => panels.forEach((panel) => panel.redraw(f)), (f) => panels.forEach((panel) => { if (panel.video) panel.redraw(f); }));
  panels.forEach(openVideo);
  if ('IntersectionObserver' in window) {
    const observer = new IntersectionObserver((entries) => entries.forEach((entry) => {
      const panel = panels.find((one) => one.canvas === entry.target);
      panel.seen = entry.isIntersecting;
      if (panel.seen) drawPanel(panel, state.frame);
      else if (panel.video) panel.video.node.pause();
    }));
    panels.forEach((panel) => observer.observe(panel.canvas));
  }
}

function hasWeights(result) { return result.weight.some((w) => w !== NO_WEIGHT); }

// As many panels per row as fit, distributed evenly: five panels are arranged as
// 5, 3 + 2 or 2 + 2 + 1. The panels of a row share its width.
function arrangePanels() {
  const width = byId('panels').clientWidth || 300;
  const most = Math.max(1, Math.min(5, Math.floor((width + 10) / 260)));
  const rows = Math.ceil(panels.length / most);
  byId('panels').style.setProperty('--in-row', String(Math.ceil(panels.length / Math.max(1, rows))));
}

export function sizePanels() {
  arrangePanels();
  panels.forEach((panel) => {
    const width = panel.canvas.clientWidth || 300, ratio = Math.min(2, window.devicePixelRatio || 1);
    panel.canvas.width = Math.round(width * ratio);
    panel.canvas.height = Math.round(width * ratio * panel.height / panel.width);
    panel.scale = panel.canvas.width / panel.width;
    panel.unit = ratio;
  });
}

// The pose to which each detection of this view and frame is matched.
function ownersIn(view, f) {
  const owners = new Map();
  results.slice().reverse().forEach((result) => {
    if (!result.match || !result.visible) return;
    for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
      if (result.extra[p] < 0) continue;
      const d = result.match[result.extra[p] * viewCount + view];
      if (d >= 0) owners.set(d, { result: result, p: p });
    }
  });
  return owners;
}

export function drawPanel(panel, f) {
  const pen = panel.canvas.getContext('2d');
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, panel.canvas.width, panel.canvas.height);
  pen.setTransform(panel.scale, 0, 0, panel.scale, 0, 0);
  const facts = paintPanel(pen, panel, f, panel.unit / panel.scale, true);
  panel.facts.textContent = facts + (panel.lacks ? (facts ? '; ' : '') + panel.lacks : '');
}

// Draws in image pixels; `px` is the size of a screen pixel in image pixels. Returns
// text about the detections.
export function paintPanel(pen, panel, f, px, withPicture) {
  panel.lacks = '';
  if (withPicture) drawPicture(pen, panel, f);
  results.forEach((result) => { if (result.visible) drawReprojections(pen, panel, result, f, px); });
  return detections ? drawDetections(pen, panel, f, px) : '';
}

function drawReprojections(pen, panel, result, f, px) {
  const J = result.joints.length;
  pen.lineCap = 'round';
  pen.setLineDash([]);
  for (let p = result.start[f]; p < result.start[f + 1]; ++p) {
    const points = [];
    for (let j = 0; j < J; ++j) {
      const at = (p * J + j) * 3;
      points.push((result.status[p * J + j] & 3) === MISSING ? null : project(panel.camera, result.xyz[at], result.xyz[at + 1], result.xyz[at + 2]));
    }
    pen.strokeStyle = colourOf(result, result.person[p]);
    for (const [a, b] of result.bones) {
      if (!points[a] || !points[b]) continue;
      const inferred = Math.min(result.status[p * J + a] & 3, result.status[p * J + b] & 3) === INFERRED;
      pen.globalAlpha = inferred ? 0.35 : 0.8;
      pen.lineWidth = (result.index === 0 ? 4 : 1.8) * px;
      pen.beginPath();
      pen.moveTo(points[a][0], points[a][1]);
      pen.lineTo(points[b][0], points[b][1]);
      pen.stroke();
    }
    pen.fillStyle = pen.strokeStyle;
    for (const j of result.bare) {
      if (!points[j]) continue;
      pen.globalAlpha = (result.status[p * J + j] & 3) === INFERRED ? 0.35 : 0.8;
      pen.beginPath();
      pen.arc(points[j][0], points[j][1], (result.index === 0 ? 4 : 2.5) * px, 0, 7);
      pen.fill();
    }
  }
  pen.globalAlpha = 1;
}

function drawDetections(pen, panel, f, px) {
  if (f % data.extrasStride !== 0) return 'detections of this frame were left out to save space';
  const slot = f * viewCount + panel.view, D = detections.joints.length;
  const owners = ownersIn(panel.view, f);
  let matched = 0, rejected = 0, missing = 0;
  const ink = dark() ? '#e7ebf0' : '#1b2430', bad = dark() ? '#ff8f66' : '#b3330c';
  const total = detections.start[slot + 1] - detections.start[slot];
  for (let d = 0; d < total; ++d) {
    const base = (detections.start[slot] + d) * D, owner = owners.get(d);
    const at = (j) => [detections.xy[(base + j) * 2] * detections.quantum, detections.xy[(base + j) * 2 + 1] * detections.quantum];
    const found = (j) => detections.confidence[base + j] > 0;
    if (owner) ++matched;
    pen.strokeStyle = owner ? ink : (dark() ? '#9aa6b5' : '#5b6675');
    pen.lineWidth = 1.1 * px;
    pen.setLineDash(owner ? [] : [3 * px, 3 * px]);
    pen.beginPath();
    for (const [a, b] of detections.bones) {
      if (!found(a) || !found(b)) continue;
      pen.moveTo(...at(a));
      pen.lineTo(...at(b));
    }
    pen.stroke();
    pen.setLineDash([]);
    for (let j = 0; j < D; ++j) {
      const verdict = owner ? jointVerdict(owner, panel.view, j) : 'kept';
      if (!found(j)) {
        if (owner && drawMissing(pen, panel, owner, j, px, ink)) ++missing;
        continue;
      }
      const [x, y] = at(j);
      pen.beginPath();
      if (verdict === 'rejected') {
        ++rejected;
        pen.strokeStyle = bad;
        pen.lineWidth = 2 * px;
        const r = 4 * px;
        pen.moveTo(x - r, y - r); pen.lineTo(x + r, y + r); pen.moveTo(x - r, y + r); pen.lineTo(x + r, y - r);
      } else {
        pen.strokeStyle = owner ? ink : (dark() ? '#9aa6b5' : '#5b6675');
        pen.lineWidth = 1.1 * px;
        pen.arc(x, y, 2.2 * px, 0, 7);
      }
      pen.stroke();
    }
    drawOwner(pen, panel, owner, base, px);
  }
  return 'detections ' + total + ', matched ' + matched + '; joints rejected ' + rejected + ', not found ' + missing;
}

function drawOwner(pen, panel, owner, base, px) {
  if (!owner) return;
  let top = null;
  for (let j = 0; j < detections.joints.length; ++j) {
    if (!detections.confidence[base + j]) continue;
    const x = detections.xy[(base + j) * 2] * detections.quantum, y = detections.xy[(base + j) * 2 + 1] * detections.quantum;
    if (!top || y < top[1]) top = [x, y];
  }
  if (!top) return;
  // The person's colour is a dot, because the name must be legible on any image.
  const x = top[0] + 5 * px, y = top[1] - 9 * px;
  const name = nameOf(owner.result, owner.result.person[owner.p]) + (owner.result.index > 0 ? ' (' + owner.result.label + ')' : '');
  pen.font = '600 ' + 12 * px + 'px system-ui, sans-serif';
  pen.lineWidth = 3 * px;
  pen.strokeStyle = dark() ? '#0d1116' : '#e9edf2';
  pen.fillStyle = dark() ? '#e7ebf0' : '#1b2430';
  pen.strokeText(name, x + 6 * px, y + 4 * px);
  pen.fillText(name, x + 6 * px, y + 4 * px);
  pen.fillStyle = colourOf(owner.result, owner.result.person[owner.p]);
  pen.beginPath();
  pen.arc(x, y, 3.5 * px, 0, 7);
  pen.fill();
}

function ownJoint(result, j) {
  if (!result.jointOf) result.jointOf = detections.joints.map((name) => result.joints.indexOf(name));
  return result.jointOf[j];
}

function jointVerdict(owner, view, j) {
  const own = ownJoint(owner.result, j), J = owner.result.joints.length;
  if (own < 0) return 'kept';
  return owner.result.weight[(owner.result.extra[owner.p] * viewCount + view) * J + own] < REJECTED ? 'rejected' : 'kept';
}

// A joint that the detector did not find, at the projection of the 3D pose.
function drawMissing(pen, panel, owner, j, px, ink) {
  const own = ownJoint(owner.result, j), J = owner.result.joints.length;
  if (own < 0 || (owner.result.status[owner.p * J + own] & 3) === MISSING) return false;
  const at = (owner.p * J + own) * 3, xyz = owner.result.xyz;
  const point = project(panel.camera, xyz[at], xyz[at + 1], xyz[at + 2]);
  if (!point) return false;
  pen.strokeStyle = ink;
  pen.lineWidth = px;
  pen.strokeRect(point[0] - 3 * px, point[1] - 3 * px, 6 * px, 6 * px);
  return true;
}
