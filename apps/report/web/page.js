// Assembles the page.
import { PALETTE, byId, dark, data, element, frameCount, results, times } from './data.js';
import { Scene, show } from './scene.js';
import { drawPanel, makePanels, panels, sizePanels } from './panels.js';
import { charts, makeCharts } from './charts.js';
import { listMoments, makeFindings, makeMoments, makeSummary } from './summary.js';
import { corrections, correctionsText, drawEdits, makeIdentity } from './identity.js';
import { SPEEDS, onFrame, onKey, pause, play, setFrame, state, tick, update } from './playback.js';
import { pngUrl, savePng, saveSvg, svgPicture } from './keep.js';

function applyTheme(isDark) {
  document.documentElement.classList.toggle('dark', isDark);
  byId('theme').textContent = isDark ? 'Light' : 'Dark';
  if (state.scene) state.scene.recolour();
  if (panels.length) panels.forEach((panel) => drawPanel(panel, state.frame));
  charts.forEach((chart) => chart.draw());
  if (charts.length) listMoments();
}

function resize() {
  if (state.scene) state.scene.resize();
  sizePanels();
  charts.forEach((chart) => chart.draw());
  update();
}

function makeHeader() {
  byId('title').textContent = data.title;
  const seconds = times[frameCount - 1] - times[0];
  byId('subtitle').textContent = frameCount + ' frames, ' + seconds.toFixed(1) + ' s, ' + results[0].ids.length + (results[0].ids.length === 1 ? ' identity' : ' identities')
    + (data.cameras.length ? ', ' + data.cameras.length + ' cameras' : '');
  const notes = [];
  if (data.assumedRate) notes.push('The times of the frames are missing or do not ascend: ' + data.assumedRate + ' frames per second are assumed.');
  if (data.frameStride > 1) notes.push('To save space, this page contains one frame in ' + data.frameStride + '.');
  if (data.extrasStride > 1) notes.push('One frame in ' + data.extrasStride + ' of the page has detections and covariances.');
  byId('notes').textContent = notes.join(' ');
  byId('notes').hidden = notes.length === 0;
  const megabytes = (bytes) => (bytes / 1e6).toFixed(1) + ' MB';
  const sizes = [];
  if (data.bytes.detections) sizes.push('detections ' + megabytes(data.bytes.detections));
  if (data.bytes.pictures) sizes.push('pictures ' + megabytes(data.bytes.pictures));
  if (data.bytes.covariances) sizes.push('covariances ' + megabytes(data.bytes.covariances));
  if (sizes.length) byId('sizes').textContent = 'Parts of this page: ' + sizes.join(', ') + '.';
  results.forEach((result) => {
    const box = element('input', { type: 'checkbox', checked: true });
    box.addEventListener('change', () => { result.visible = box.checked; update(); });
    const style = results.length < 2 ? '' : result.truth ? ' (ground truth: thin, grey)' : result.index ? ' (thin)' : ' (thick)';
    byId('results').append(element('label', {}, [box, ' ' + result.label, element('span', { className: 'style', textContent: style })]));
  });
}

function connect() {
  byId('scrub').max = frameCount - 1;
  byId('scrub').addEventListener('input', () => { pause(); setFrame(Number(byId('scrub').value)); });
  byId('play').addEventListener('click', () => (state.playing ? pause() : play()));
  byId('step-back').addEventListener('click', () => { pause(); setFrame(state.frame - 1); });
  byId('step-on').addEventListener('click', () => { pause(); setFrame(state.frame + 1); });
  SPEEDS.forEach((speed) => byId('speed').append(element('option', { value: String(speed), textContent: speed + '\u00d7' })));
  byId('speed').value = '1';
  byId('speed').addEventListener('change', () => { state.speed = Number(byId('speed').value); });
  ['trails', 'labels', 'cameras', 'floor', 'ellipsoids'].forEach((name) => {
    byId('show-' + name).addEventListener('change', (event) => { show[name] = event.target.checked; update(); });
  });
  byId('ellipsoid-option').hidden = !results.some((result) => result.covariance);
  byId('reset-view').addEventListener('click', () => state.scene && state.scene.home());
  byId('save-png').addEventListener('click', savePng);
  byId('save-svg').addEventListener('click', saveSvg);
  byId('theme').addEventListener('click', () => applyTheme(!dark()));
  byId('help-button').addEventListener('click', () => {
    byId('help').hidden = !byId('help').hidden;
    byId('help-button').setAttribute('aria-expanded', String(!byId('help').hidden));
  });
  document.addEventListener('keydown', onKey);
  window.addEventListener('resize', resize);
}

document.documentElement.classList.toggle('dark', window.matchMedia('(prefers-color-scheme: dark)').matches);
makeHeader();
try {
  state.scene = new Scene(byId('scene'));
  onFrame((f) => state.scene.setFrame(f));
} catch (error) {
  byId('no-webgl').hidden = false;
}
makePanels();
makeCharts(drawEdits);
makeMoments();
makeFindings();
makeSummary();
makeIdentity();
connect();
applyTheme(dark());
resize();
window.requestAnimationFrame(tick);
// Interface for tests and the browser's console.
window.kinegraph = { state: state, setFrame: setFrame, play: play, pause: pause, results: results, scene: state.scene, panels: panels, palette: PALETTE,
  svgPicture: svgPicture, pngUrl: pngUrl, corrections: corrections, correctionsText: correctionsText };
