// The worst moments.
import { LENGTH, SPEED, byId, colourOf, data, element, nameOf, results } from './data.js';
import { human, jointName, referenceName } from './charts.js';
import { pause, setFrame } from './playback.js';

const KINDS = {
  residual: ['largest residual', (m) => ': ' + human(m.value) + ' px off the detection in ' + m.detail],
  speed: ['speed jump', (m) => ', ' + jointName(m.detail) + ': velocity jumps by ' + human(SPEED.per * m.value) + ' ' + SPEED.unit],
  bone: ['bone length jump', (m) => ', ' + jointName(m.detail) + ': length jumps by ' + human(LENGTH.per * m.value) + ' ' + LENGTH.unit],
  difference: [results.some((r) => r.truth) ? 'far from the truth' : 'results differ', (m) => ': ' + human(LENGTH.per * m.value) + ' ' + LENGTH.unit + ' from ' + referenceName()],
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
