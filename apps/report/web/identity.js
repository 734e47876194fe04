// Identities: the decisions of linking, and corrections.
import { byId, dark, element, frameCount, frameNumbers, nameOf, results } from './data.js';
import { charts, human } from './charts.js';
import { pause, setFrame, state } from './playback.js';

// Corrections made on this page. Together with the lines of NAME.identity.jsonl
// they form a file for `track --corrections`.
export const corrections = [];

function callPerson(result, id) {
  const person = result.ids.indexOf(id);
  return person < 0 ? id : nameOf(result, person);
}

function tellEdit(result, edit) {
  const who = edit.persons.map((id) => callPerson(result, id));
  const margin = edit.margin === undefined ? '' : ' (margin ' + human(edit.margin) + ')';
  switch (edit.op) {
    case 'join': return who[1] + ' is ' + who[0] + margin;
    case 'undecided': return who[1] + ' may be ' + who[0] + margin;
    case 'swap': return who[0] + ' and ' + who[1] + ' exchanged' + margin;
    case 'cut': return who[0] + (edit.persons[1] === undefined ? ' is someone else in these frames' : ' becomes ' + who[1]) + margin;
    case 'delete': return who[0] + ' is not a person';
    default: return edit.persons[0] + ' is called ' + edit.name;
  }
}

// Index on the page's clock of the frame from which an edit applies (a join, also
// an undecided one: the first frame of the second person); -1: none.
function placeOf(edit) {
  if (!edit.frames) return -1;
  const number = edit.op === 'join' || edit.op === 'undecided' ? edit.frames[1] : edit.frames[0];
  let f = 0;
  while (f < frameCount - 1 && frameNumbers[f + 1] <= number) ++f;
  return f;
}

// Marks edits in the chart of presence, in the rows of the people concerned.
export function drawEdits(pen, width, shown, rowHeight) {
  const row = (result, id) => shown.findIndex((one) => one.result === result && one.result.ids[one.person] === id);
  const draw = (result, edit, ids, mine) => {
    const f = placeOf(edit);
    if (f < 0) return;
    const x = Math.min(width - 3, (f + 0.5) * width / frameCount);
    new Set(ids.map((id) => row(result, id))).forEach((i) => {
      if (i < 0) return;
      const y = (i + 0.5) * rowHeight, size = Math.min(5, rowHeight / 2);
      pen.beginPath();
      [[0, -size], [size, 0], [0, size], [-size, 0]].forEach(([dx, dy]) => pen.lineTo(x + dx, y + dy));
      pen.closePath();
      pen.lineWidth = 1.5;
      pen.strokeStyle = mine ? '#d55e00' : dark() ? '#ffffff' : '#000000';
      pen.fillStyle = edit.op === 'undecided' ? 'transparent' : dark() ? '#1b2430' : '#ffffff';
      pen.fill();
      pen.stroke();
    });
  };
  results.forEach((result) => result.edits.forEach((edit) => draw(result, edit, edit.now, false)));
  corrections.forEach((edit) => draw(results[0], edit, edit.persons, true));
}

function lineOfCorrection(edit) {
  // Identities may exceed JavaScript's integers, so they remain strings.
  const parts = ['"op": ' + JSON.stringify(edit.op), '"persons": [' + edit.persons.join(', ') + ']'];
  if (edit.frames) parts.push('"frames": [' + edit.frames.join(', ') + ']');
  if (edit.name) parts.push('"name": ' + JSON.stringify(edit.name));
  return '{' + parts.join(', ') + '}';
}

export function correctionsText() {
  return results[0].lines.concat(corrections.map(lineOfCorrection)).map((line) => line + '\n').join('');
}

function listEdits() {
  const list = byId('edits'), lead = results[0];
  list.textContent = '';
  const add = (edit, mine) => {
    const f = placeOf(edit);
    const button = element('button', { type: 'button' }, [element('span', { className: 'what', textContent: tellEdit(lead, edit) }),
      element('span', { className: 'when', textContent: edit.frames ? edit.frames.join('\u2013') : '' })]);
    button.title = edit.op;
    if (f >= 0) button.addEventListener('click', () => { pause(); setFrame(f); });
    const item = element('li', { className: mine ? 'mine' : '' }, [button]);
    if (mine) {
      const undo = element('button', { type: 'button', className: 'undo', textContent: '\u00d7', title: 'Undo' });
      undo.addEventListener('click', () => { corrections.splice(corrections.indexOf(edit), 1); changed(); });
      item.append(undo);
    }
    list.append(item);
  };
  lead.edits.forEach((edit) => add(edit, false));
  corrections.forEach((edit) => add(edit, true));
  if (!list.firstChild) list.append(element('li', { textContent: 'no changes' }));
  byId('save-edits').disabled = corrections.length === 0;
}

function changed() {
  listEdits();
  charts.forEach((chart) => chart.draw());
}

// The edit in the form, or an error message.
function readCorrection() {
  const op = byId('edit-op').value, one = byId('edit-one').value, other = byId('edit-other').value;
  const edit = { op: op, persons: [one] };
  if (op === 'join' || op === 'swap') {
    if (one === other) return 'two people are needed';
    edit.persons.push(other);
  }
  if (op === 'name') {
    edit.name = byId('edit-name').value.trim();
    return edit.name ? edit : 'a name is needed';
  }
  if (op === 'join') return edit;
  edit.frames = [Number(byId('edit-first').value), Number(byId('edit-last').value)];
  return edit.frames[0] <= edit.frames[1] ? edit : 'the last frame is before the first';
}

function showFields() {
  const op = byId('edit-op').value;
  byId('edit-other').hidden = op !== 'join' && op !== 'swap';
  byId('edit-name').hidden = op !== 'name';
  byId('edit-range').hidden = op === 'name' || op === 'join';
}

export function makeIdentity() {
  const lead = results[0];
  if (lead.truth || !lead.ids.length) return;
  byId('identity-card').hidden = false;
  ['edit-one', 'edit-other'].forEach((select) => lead.ids.forEach((id, person) => {
    byId(select).append(element('option', { value: id, textContent: nameOf(lead, person) }));
  }));
  byId('edit-first').value = frameNumbers[0];
  byId('edit-last').value = frameNumbers[frameCount - 1];
  byId('edit-from').addEventListener('click', () => { byId('edit-first').value = frameNumbers[state.frame]; });
  byId('edit-to').addEventListener('click', () => { byId('edit-last').value = frameNumbers[state.frame]; });
  byId('edit-op').addEventListener('change', showFields);
  byId('edit-add').addEventListener('click', () => {
    const edit = readCorrection();
    byId('edit-wrong').textContent = typeof edit === 'string' ? edit : '';
    if (typeof edit === 'string') return;
    corrections.push(edit);
    changed();
  });
  byId('save-edits').addEventListener('click', () => {
    const link = element('a', { download: 'corrections.jsonl', href: 'data:application/jsonl;charset=utf-8,' + encodeURIComponent(correctionsText()) });
    link.click();
  });
  byId('identity-toggle').addEventListener('click', () => {
    byId('identity-body').hidden = !byId('identity-body').hidden;
    byId('identity-toggle').setAttribute('aria-expanded', String(!byId('identity-body').hidden));
  });
  showFields();
  listEdits();
}
