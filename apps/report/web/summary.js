// The findings above the 3D view; summary and worst moments beside it.
import { LENGTH, NO_VALUE, SPEED, byId, colourOf, data, element, nameOf, results } from './data.js';
import { pause, setFrame } from './playback.js';
import { human, jointName, referenceName } from './charts.js';

function medianOf(values) {
  const sorted = Array.from(values).filter((v) => v === v).sort((a, b) => a - b);
  return sorted.length ? sorted[Math.floor(sorted.length / 2)] : NaN;
}

function summaryTable(summary) {
  const table = element('table', {}, [element('tr', {}, ['camera', 'matched', 'median', 'p90'].map((text) => element('th', { textContent: text })))]);
  summary.cameras.forEach((camera) => table.append(element('tr', {}, [camera.view, Math.round(100 * camera.matched_share) + ' %',
    human(camera.median_px) + ' px', human(camera.p90_px) + ' px'].map((text) => element('td', { textContent: text })))));
  return table;
}

// Lines on the solver.
function solverLines(summary) {
  const lines = [];
  const solver = summary.solver;
  if (solver && solver.solves > 0) {
    lines.push(solver.name + ': ' + solver.solves + ' solves, '
      + (solver.not_converged + solver.failed > 0 ? solver.not_converged + ' not converged, ' + solver.failed + ' failed' : 'all converged'));
  }
  return lines;
}

// The noise learnt by `track`, in a collapsed part.
function learntPart(summary) {
  const noise = summary.noise;
  if (!noise || !noise.classes) return null;
  const row = (tag, cells) => element('tr', {}, cells.map((text) => element(tag, { textContent: text })));
  const rows = Object.keys(noise.classes).map((name) => {
    const one = noise.classes[name];
    return row('td', [name, human(one.sigma_px) + ' px', human(one.process_noise)]);
  });
  const part = element('details', {}, [element('summary', { textContent: 'Learnt from the recording' })]);
  if (noise.error_time_s) part.append(element('p', { textContent: 'Correlation time of the detector\u2019s errors: ' + human(noise.error_time_s) + ' s.' }));
  if (noise.confidence_power !== undefined) part.append(element('p', { textContent: 'The errors are proportional to confidence to the power of ' + human(-noise.confidence_power) + '.' }));
  part.append(element('table', {}, [row('th', ['joints', 'error', 'process noise, m\u00b2/s\u00b3'])].concat(rows)));
  return part;
}

// Warnings of `track`, then findings of `doctor`.
export function makeFindings() {
  const list = byId('finding-list'), several = results.filter((result) => !result.truth).length > 1;
  // A flag of a command is not wrapped if it fits into a line.
  const words = (remedy) => remedy.split(/(--\S+)/).map((part) => (part.startsWith('--') ? element('code', { textContent: part }) : part));
  const add = (text, remedy) => list.append(element('li', {}, [text + '. ', element('span', { className: 'try' }, ['Try: '].concat(words(remedy)))]));
  const findings = data.doctor && data.doctor.findings || [];
  results.forEach((result, r) => {
    const summary = data.results[r].summary;
    // Warnings that the doctor also reports are shown once.
    const isFound = (warning) => findings.some((finding) => (finding.evidence || '').includes(warning.text));
    (summary && summary.warnings || []).filter((warning) => !isFound(warning)).forEach((warning) => add((several ? result.label + ': ' : '') + warning.text, warning.try));
  });
  findings.forEach((finding) => {
    const px = finding.after_px > 0 ? ', residual ' + human(finding.before_px) + ' to ' + human(finding.after_px) + ' px' : '';
    add('Doctor: ' + finding.kind.replace(/_/g, ' ') + (finding.camera ? ' of ' + finding.camera : '') + ', confidence '
      + Number(finding.confidence).toFixed(2) + px + (finding.evidence ? '; ' + finding.evidence : ''), finding.fix);
  });
  byId('findings').hidden = !list.firstChild;
}

// The summary of `track` for each result, and distances between results.
export function makeSummary() {
  const box = byId('summary');
  const line = (text, kind) => box.append(element('p', { textContent: text, className: kind || '' }));
  results.forEach((result, r) => {
    const summary = data.results[r].summary;
    if (results.length > 1 && summary) box.append(element('b', { textContent: result.label }));
    if (summary) {
      box.append(summaryTable(summary));
      const tall = summary.people.filter((person) => person.height_m).sort((a, b) => b.frames - a.frames).slice(0, 6);
      line(summary.people.length + (summary.people.length === 1 ? ' identity' : ' identities') + ', up to ' + summary.most_people_in_a_view + ' in one view (in 5 % of the frames or more)'
        + (tall.length ? '; heights ' + tall.map((person) => person.height_m.toFixed(2) + ' m').join(', ') : ''));
      solverLines(summary).forEach((text) => line(text));
      if (summary.warnings.length) line(summary.warnings.length + (summary.warnings.length > 1 ? ' warnings' : ' warning') + ', at the top of the page', 'warning');
      const learnt = learntPart(summary);
      if (learnt) box.append(learnt);
    }
    if (result.difference && !result.truth) {
      const apart = medianOf(Array.from(result.difference, (d) => (d === NO_VALUE ? NaN : 0.001 * LENGTH.per * d)));
      if (apart === apart) line(result.label + ': ' + human(apart) + ' ' + LENGTH.unit + ' from ' + referenceName(result) + ' (median)');
    }
  });
  if (data.doctor) line('Doctor: ' + data.doctor.verdict + (data.doctor.findings.length ? ', see the top of the page' : data.doctor.mended ? ', corrected by the configuration' : ''), data.doctor.findings.length ? 'warning' : '');
  byId('summary-card').hidden = !box.firstChild;
}

const KINDS = {
  residual: ['largest residual', (m) => ': ' + human(m.value) + ' px from the detection in ' + m.detail],
  speed: ['speed jump', (m) => ', ' + jointName(m.detail) + ': velocity jumps by ' + human(SPEED.per * m.value) + ' ' + SPEED.unit],
  bone: ['unusual bone length', (m) => ', ' + jointName(m.detail) + ': length ' + human(LENGTH.per * m.value) + ' ' + LENGTH.unit + ' from its median'],
  difference: [results.some((r) => r.truth) ? 'far from the truth' : 'results differ', (m) => ': ' + human(LENGTH.per * m.value) + ' ' + LENGTH.unit + ' from ' + referenceName(results[m.result])],
  start: ['identity appears', () => ' appears'],
  end: ['identity is lost', () => ' is lost']
};

export function makeMoments() {
  const select = byId('moment-kind');
  select.append(element('option', { value: '', textContent: 'all kinds' }));
  Object.keys(KINDS).filter((kind) => data.moments.some((m) => m.kind === kind))
    .forEach((kind) => select.append(element('option', { value: kind, textContent: KINDS[kind][0] })));
  select.addEventListener('change', listMoments);
  listMoments();
}

export function listMoments() {
  const kind = byId('moment-kind').value, list = byId('moments');
  list.textContent = '';
  data.moments.filter((m) => !kind || m.kind === kind).forEach((moment) => {
    const result = results[moment.result], person = result.ids.indexOf(moment.id);
    const dot = element('span', { className: 'dot' });
    dot.style.background = colourOf(result, person);
    const what = data.who + ' ' + nameOf(result, person) + KINDS[moment.kind][1](moment) + (result.index > 0 ? ' (' + result.label + ')' : '');
    const button = element('button', { type: 'button' }, [dot, element('span', { className: 'what', textContent: what }), element('span', { className: 'when', textContent: String(moment.frame) })]);
    button.title = KINDS[moment.kind][0];
    button.dataset.at = moment.at;
    button.addEventListener('click', () => { pause(); setFrame(moment.at); });
    list.append(element('li', {}, [button]));
  });
  if (!list.firstChild) list.append(element('li', { textContent: 'none' }));
}
