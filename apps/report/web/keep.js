// Export of the displayed frame as SVG and PNG.
import { INFERRED, MISSING, colourOf, dark, data, element, frameNumbers, nameOf, results, times } from './data.js';
import { headOf, reach, scratch, show, up } from './scene.js';
import { paintPanel, panels } from './panels.js';
import { state } from './playback.js';

// Implements the subset of a canvas context that the page uses, and writes SVG.
class SvgPen {
  constructor() {
    Object.assign(this, { out: [], clips: [], x: 0, y: 0, scale: 1, path: '', dash: [], fillStyle: '#000', strokeStyle: '#000', lineWidth: 1,
      globalAlpha: 1, font: '12px sans-serif', textAlign: 'left', lineCap: 'butt' });
  }
  // Translation and uniform scale only.
  setTransform(scale, b, c, d, x, y) { Object.assign(this, { x: x, y: y, scale: scale }); }
  at(x, y) { return (this.x + this.scale * x).toFixed(1) + ' ' + (this.y + this.scale * y).toFixed(1); }
  long(length) { return (this.scale * length).toFixed(2); }
  colour(name, value) {
    return ' ' + name + '="' + value + '"' + (this.globalAlpha < 1 ? ' ' + name + '-opacity="' + this.globalAlpha.toFixed(2) + '"' : '');
  }
  outline(style) {
    return ' fill="none"' + this.colour('stroke', style) + ' stroke-width="' + this.long(this.lineWidth) + '" stroke-linecap="' + this.lineCap + '"'
      + (this.dash.length ? ' stroke-dasharray="' + this.dash.map((d) => this.long(d)).join(' ') + '"' : '');
  }
  beginPath() { this.path = ''; }
  moveTo(x, y) { this.path += 'M' + this.at(x, y); }
  lineTo(x, y) { this.path += 'L' + this.at(x, y); }
  arc(x, y, r) {
    const turn = 'A' + this.long(r) + ' ' + this.long(r) + ' 0 1 1 ';
    this.path += 'M' + this.at(x - r, y) + turn + this.at(x + r, y) + turn + this.at(x - r, y);
  }
  stroke() { if (this.path) this.out.push('<path d="' + this.path + '"' + this.outline(this.strokeStyle) + '/>'); }
  fill() { if (this.path) this.out.push('<path d="' + this.path + '"' + this.colour('fill', this.fillStyle) + '/>'); }
  box(x, y, width, height) {
    const [left, top] = this.at(x, y).split(' ');
    return '<rect x="' + left + '" y="' + top + '" width="' + this.long(width) + '" height="' + this.long(height) + '"';
  }
  fillRect(x, y, width, height) { this.out.push(this.box(x, y, width, height) + this.colour('fill', this.fillStyle) + '/>'); }
  strokeRect(x, y, width, height) { this.out.push(this.box(x, y, width, height) + this.outline(this.strokeStyle) + '/>'); }
  setLineDash(dash) { this.dash = dash; }
  // Clipping to a rectangle until restore().
  save() {}
  rect(x, y, width, height) { this.frame = '<rect x="' + x + '" y="' + y + '" width="' + width + '" height="' + height + '"/>'; }
  clip() {
    const id = 'clip' + this.clips.length;
    this.clips.push('<clipPath id="' + id + '">' + this.frame + '</clipPath>');
    this.out.push('<g clip-path="url(#' + id + ')">');
  }
  restore() {
    this.setTransform(1, 0, 0, 1, 0, 0);
    this.out.push('</g>');
  }
  text(text, x, y, how) {
    const [left, top] = this.at(x, y).split(' '), size = /([\d.]+)px/.exec(this.font)[1];
    const anchor = { left: 'start', center: 'middle', right: 'end' }[this.textAlign];
    this.out.push('<text x="' + left + '" y="' + top + '" font-family="sans-serif" font-size="' + this.long(size) + '"'
      + (/^600/.test(this.font) ? ' font-weight="600"' : '') + ' text-anchor="' + anchor + '"' + how + '>' + escaped(text) + '</text>');
  }
  fillText(text, x, y) { this.text(text, x, y, this.colour('fill', this.fillStyle)); }
  strokeText(text, x, y) { this.text(text, x, y, this.outline(this.strokeStyle)); }
  drawImage(image, x, y, width, height) {
    if (image.tagName === 'VIDEO') return this.drawVideo(image, x, y, width, height);
    this.out.push(this.box(x, y, width, height).replace('<rect', '<image') + ' preserveAspectRatio="none" href="' + escaped(image.src) + '"/>');
  }
  // Embeds the image of the video; linked videos cannot be read and are left out.
  drawVideo(video, x, y, width, height) {
    const canvas = element('canvas', { width: video.videoWidth, height: video.videoHeight });
    canvas.getContext('2d').drawImage(video, 0, 0);
    try {
      this.drawImage({ src: canvas.toDataURL('image/jpeg') }, x, y, width, height);
    } catch (error) {
      // Browsers forbid reading linked files; the lines are still drawn.
    }
  }
}

function escaped(text) {
  return String(text).replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' }[c]));
}

// Layout of the picture: the 3D view, and the panels in rows below.
function pictureLayout() {
  const width = 1600, gap = 12, head = 30;
  const stage = { x: 0, y: head, width: width, height: state.scene ? Math.round(width * state.scene.height / state.scene.width) : 0 };
  const count = panels.length, inRow = Math.max(1, Math.ceil(count / Math.max(1, Math.ceil(count / 4))));
  let y = stage.y + stage.height + gap;
  const cells = [];
  for (let first = 0; first < count; first += inRow) {
    const row = panels.slice(first, first + inRow), across = (width - gap * (row.length - 1)) / row.length;
    let tallest = 0;
    row.forEach((panel, i) => {
      const height = across * panel.height / panel.width;
      tallest = Math.max(tallest, height);
      cells.push({ panel: panel, x: i * (across + gap), y: y, width: across, height: height });
    });
    y += tallest + 22 + gap;
  }
  return { width: width, height: Math.ceil(y), stage: stage, cells: cells };
}

function pictureTitle() {
  return data.title + ', frame ' + frameNumbers[state.frame] + ', ' + times[state.frame].toFixed(2) + ' s';
}

function pageColours() {
  return dark() ? { page: '#12161c', stage: '#0d1116', ink: '#e7ebf0', quiet: '#9aa6b5', grid: '#3a4450' }
    : { page: '#ffffff', stage: '#e9edf2', ink: '#1b2430', quiet: '#5b6675', grid: '#c3cbd4' };
}

// Maps points of the scene to their position in the picture and their depth.
function screenOf(stage) {
  const view = state.scene.camera;
  return (point) => {
    const depth = -scratch.direction.copy(point).applyMatrix4(view.matrixWorldInverse).z;
    scratch.direction.copy(point).project(view);
    return { x: stage.x + (scratch.direction.x + 1) / 2 * stage.width, y: stage.y + (1 - scratch.direction.y) / 2 * stage.height, depth: depth };
  };
}

// The 3D view as lines, drawn by decreasing depth.
function paintScene(pen, stage, colours) {
  const toScreen = screenOf(stage), scale = stage.height / 2 / Math.tan(state.scene.camera.fov * Math.PI / 360);
  const strokes = [];
  const add = (a, b, metres, colour, alpha) => {
    const from = toScreen(a), to = toScreen(b);
    if (from.depth < 0.1 || to.depth < 0.1) return;
    strokes.push({ from: from, to: to, depth: (from.depth + to.depth) / 2, width: Math.max(0.6, metres * scale * 2 / (from.depth + to.depth)), colour: colour, alpha: alpha });
  };
  if (show.floor) floorLines().forEach(([a, b]) => add(a, b, 0.004, colours.grid, 1));
  if (show.cameras) state.scene.cameraLines.forEach(([a, b]) => add(a, b, 0.006, colours.quiet, 0.9));
  results.forEach((result) => {
    if (!result.visible) return;
    const J = result.joints.length, a = new THREE.Vector3(), b = new THREE.Vector3();
    for (let p = result.start[state.frame]; p < result.start[state.frame + 1]; ++p) {
      const status = (j) => result.status[p * J + j] & 3, colour = colourOf(result, result.person[p]);
      const thick = result.index === 0 ? 0.045 : 0.02;
      result.bones.forEach(([j, k]) => {
        const least = Math.min(status(j), status(k));
        if (least === MISSING) return;
        add(a.fromArray(result.xyz, (p * J + j) * 3), b.fromArray(result.xyz, (p * J + k) * 3), thick, colour, least === INFERRED ? 0.35 : 1);
      });
      result.bare.filter((j) => status(j) !== MISSING).forEach((j) => {
        a.fromArray(result.xyz, (p * J + j) * 3);
        add(a, b.copy(a).addScaledVector(up, 1e-3), 1.5 * thick, colour, status(j) === INFERRED ? 0.35 : 1);
      });
    }
  });
  strokes.sort((one, other) => other.depth - one.depth);
  pen.lineCap = 'round';
  pen.setLineDash([]);
  strokes.forEach((stroke) => {
    pen.globalAlpha = stroke.alpha;
    pen.strokeStyle = stroke.colour;
    pen.lineWidth = stroke.width;
    pen.beginPath();
    pen.moveTo(stroke.from.x, stroke.from.y);
    pen.lineTo(stroke.to.x, stroke.to.y);
    pen.stroke();
  });
  pen.globalAlpha = 1;
}

function paintNames(pen, stage, colours) {
  const lead = results.find((result) => result.visible), toScreen = screenOf(stage);
  if (!lead || !show.labels) return;
  pen.font = '600 16px system-ui, sans-serif';
  pen.textAlign = 'center';
  for (let p = lead.start[state.frame]; p < lead.start[state.frame + 1]; ++p) {
    const at = toScreen(headOf(lead, p));
    if (at.depth < 0.1) continue;
    pen.lineWidth = 4;
    pen.strokeStyle = colours.stage;
    pen.strokeText(nameOf(lead, lead.person[p]), at.x, at.y);
    pen.fillStyle = colours.ink;
    pen.fillText(nameOf(lead, lead.person[p]), at.x, at.y);
  }
  pen.textAlign = 'left';
}

function floorLines() {
  const size = Math.ceil(reach * 1.6), lines = [];
  const point = (x, z) => new THREE.Vector3(x, 0, z).applyQuaternion(state.scene.floor.quaternion).add(state.scene.floor.position);
  for (let i = -size; i <= size; ++i) lines.push([point(i, -size), point(i, size)], [point(-size, i), point(size, i)]);
  return lines;
}

function paintTexts(pen, layout, colours) {
  pen.globalAlpha = 1;
  pen.textAlign = 'left';
  pen.fillStyle = colours.ink;
  pen.font = '600 16px system-ui, sans-serif';
  pen.fillText(pictureTitle(), 8, 21);
  pen.font = '13px system-ui, sans-serif';
  layout.cells.forEach((cell) => pen.fillText(cell.panel.camera.view, cell.x + 4, cell.y + cell.height + 16));
}

// The whole picture, for either output; `paintStage` paints the 3D view.
function paintPicture(pen, layout, paintStage, withPictures) {
  const colours = pageColours();
  pen.fillStyle = colours.page;
  pen.fillRect(0, 0, layout.width, layout.height);
  const framed = (box, paint) => {
    pen.save();
    pen.beginPath();
    pen.rect(box.x, box.y, box.width, box.height);
    pen.clip();
    pen.fillStyle = colours.stage;
    pen.fillRect(box.x, box.y, box.width, box.height);
    paint();
    pen.restore();
  };
  if (state.scene) {
    framed(layout.stage, () => {
      paintStage(pen, layout.stage, colours);
      paintNames(pen, layout.stage, colours);
    });
  }
  layout.cells.forEach((cell) => framed(cell, () => {
    const scale = cell.width / cell.panel.width;
    pen.setTransform(scale, 0, 0, scale, cell.x, cell.y);
    paintPanel(pen, cell.panel, state.frame, 1.2 / scale, withPictures);
  }));
  paintTexts(pen, layout, colours);
}

export function svgPicture() {
  const layout = pictureLayout(), pen = new SvgPen();
  paintPicture(pen, layout, paintScene, true);
  return '<svg xmlns="http://www.w3.org/2000/svg" width="' + layout.width + '" height="' + layout.height + '" viewBox="0 0 ' + layout.width + ' ' + layout.height + '">\n<defs>'
    + pen.clips.join('') + '</defs>\n' + pen.out.join('\n') + '\n</svg>\n';
}

// The canvas of the PNG. Browsers do not export canvases with linked images; with
// `withPictures` false, all images are left out.
function pngCanvas(withPictures) {
  const layout = pictureLayout(), canvas = element('canvas', { width: layout.width, height: layout.height });
  paintPicture(canvas.getContext('2d'), layout, (pen, stage) => {
    state.scene.dirty = true;
    state.scene.render();  // valid until the browser displays it
    pen.drawImage(state.scene.canvas, stage.x, stage.y, stage.width, stage.height);
  }, withPictures);
  return canvas;
}

export function pngUrl() {
  try {
    return pngCanvas(true).toDataURL('image/png');
  } catch (error) {
    return pngCanvas(false).toDataURL('image/png');
  }
}

function save(url, extension) {
  const name = data.title.replace(/[^\w.-]+/g, '_') + '_' + frameNumbers[state.frame] + '.' + extension;
  const link = element('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
}

export function savePng() { save(pngUrl(), 'png'); }

export function saveSvg() {
  const url = URL.createObjectURL(new Blob([svgPicture()], { type: 'image/svg+xml' }));
  save(url, 'svg');
  window.setTimeout(() => URL.revokeObjectURL(url), 10000);
}
