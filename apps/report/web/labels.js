// Names and cameras over the 3D view.
import { MISSING, byId, colourOf, data, nameOf, results } from './data.js';
import { scratch, show, up } from './scene.js';
import { state } from './playback.js';

const labelPool = [];
export function placeLabels(view) {
  let used = 0;
  const width = view.width, height = view.height;
  const put = (point, text, colour, className) => {
    scratch.b.copy(point).project(view.camera);
    if (scratch.b.z > 1 || Math.abs(scratch.b.x) > 1 || Math.abs(scratch.b.y) > 1) return;
    if (!labelPool[used]) labelPool.push(byId('labels').appendChild(document.createElement('span')));
    const label = labelPool[used++];
    if (label.textContent !== text) label.textContent = text;
    label.className = className;
    label.style.borderColor = colour || 'transparent';
    label.style.transform = 'translate(-50%, -100%) translate(' + ((scratch.b.x + 1) / 2 * width).toFixed(1) + 'px,' + ((1 - scratch.b.y) / 2 * height).toFixed(1) + 'px)';
    label.hidden = false;
  };
  if (show.labels) {
    if (show.cameras) data.cameras.forEach((camera, c) => put(view.frusta[c], camera.view, '', 'camera'));
    const result = results.find((r) => r.visible);
    if (result) {
      for (let p = result.start[state.frame]; p < result.start[state.frame + 1]; ++p) {
        put(headOf(result, p), nameOf(result, result.person[p]), colourOf(result, result.person[p]), '');
      }
    }
  }
  for (let i = used; i < labelPool.length; ++i) labelPool[i].hidden = true;
}

export function headOf(result, p) {
  const J = result.joints.length;
  let best = -Infinity;
  for (let j = 0; j < J; ++j) {
    if ((result.status[p * J + j] & 3) === MISSING) continue;
    scratch.b.fromArray(result.xyz, (p * J + j) * 3);
    const height = scratch.b.dot(up);
    if (height > best) { best = height; scratch.a.copy(scratch.b); }
  }
  return scratch.a.addScaledVector(up, 0.14);
}
