// The timelines and their data series.
import { LENGTH, MISSING, NO_ANGLE, NO_VALUE, PALETTE, SPEED, byId, colourOf, dark, data, decode, element, frameCount, lastAtMost, nameOf, results, times, viewCount } from './data.js';
import { onFrame, pause, setFrame } from './playback.js';

// Space left of a plot for names and the numbers of the axis [px].
function gutter() { return window.innerWidth < 760 ? 58 : 110; }

// A number with at most three significant digits below 1000 and no exponent.
export function human(value) {
  const size = Math.abs(value);
  if (size >= 100 || Number.isInteger(value)) return String(Math.round(value));
  return value.toFixed(size >= 10 ? 0 : size >= 1 ? 1 : 2);
}

// "left ankle" of "l_ankle".
export function jointName(name) {
  return name.replace(/\b([lr])_/g, (all, side) => (side === 'l' ? 'left ' : 'right ')).replace(/_/g, ' ');
}

const AXIS = 16;  // px under a plot, for times

// The index of the frame at a time, with a fraction between two frames. Frames are
// evenly spaced in a plot although there may be gaps between their times.
function placeOfTime(time) {
  const f = lastAtMost(times, time), next = times[f + 1];
  return next > times[f] ? f + (time - times[f]) / (next - times[f]) : f;
}

// Labels the first and last time, and a few round times in between.
function drawTimeAxis(pen, width, height) {
  const first = times[0], last = times[frameCount - 1], span = last - first;
  pen.fillStyle = dark() ? '#9aa6b5' : '#5b6675';
  pen.font = '11px system-ui, sans-serif';
  pen.fillRect(0, height, width, 1);
  const digits = span < 20 ? 1 : 0;
  const text = (time) => time.toFixed(digits) + ' s';
  pen.textAlign = 'left';
  pen.fillText(text(first), 0, height + AXIS - 3);
  pen.textAlign = 'right';
  pen.fillText(text(last), width, height + AXIS - 3);
  pen.textAlign = 'center';
  if (!(span > 0)) return;
  let step = Math.pow(10, Math.floor(Math.log10(span / 3)));
  while (span / step > width / 90) step *= 2;
  let free = 70;
  for (let time = Math.ceil(first / step) * step; time < last; time += step) {
    const x = placeOfTime(time) / Math.max(1, frameCount - 1) * width;
    if (x < free || x > width - 70) continue;
    free = x + 70;
    pen.fillRect(x, height - 3, 1, 4);
    pen.fillText(text(time), x, height + AXIS - 3);
  }
  pen.textAlign = 'left';
}

export const charts = [];
class Chart {
  constructor(title, height, draw) {
    this.head = element('div', { className: 'head' }, [element('b', { textContent: title })]);
    this.canvas = element('canvas');
    this.cursor = element('div', { className: 'cursor' });
    this.plot = element('div', { className: 'plot' }, [this.canvas, this.cursor]);
    byId('charts').append(element('div', { className: 'chart' }, [this.head, this.plot]));
    this.height = height;
    this.drawInto = draw;
    const seek = (event) => {
      const box = this.plot.getBoundingClientRect(), left = gutter();
      setFrame(Math.round((event.clientX - box.left - left) / (box.width - left) * (frameCount - 1)));
    };
    // A finger that scrolls the page must not seek: only a tap or a horizontal
    // movement does.
    let from = null;
    this.plot.addEventListener('pointerdown', (event) => {
      this.plot.setPointerCapture(event.pointerId);
      from = event.clientX;
      pause();
      if (event.pointerType !== 'touch') seek(event);
    });
    this.plot.addEventListener('pointermove', (event) => {
      if (from === null) return;
      if (event.pointerType !== 'touch' || Math.abs(event.clientX - from) > 8) seek(event);
    });
    this.plot.addEventListener('pointerup', (event) => { if (from !== null) seek(event); from = null; });
    this.plot.addEventListener('pointercancel', () => { from = null; });
    charts.push(this);
  }
  draw() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    this.width = this.plot.clientWidth || 300;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round((this.height + AXIS) * ratio);
    this.canvas.style.height = (this.height + AXIS) + 'px';
    const pen = this.canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.translate(gutter(), 0);
    this.drawInto(pen, this.width - gutter(), this.height);
    drawTimeAxis(pen, this.width - gutter(), this.height);
  }
  moveCursor(f) {
    this.cursor.style.transform = 'translateX(' + (gutter() + f / Math.max(1, frameCount - 1) * (this.width - gutter() - 1)).toFixed(1) + 'px)';
  }
}

// The axis begins at 0. If the caller sets the chart's `fromZero` to false, it
// begins just below most values; if to null, it covers their whole range.
function lineChart(title, unit, height, seriesOf) {
  const chart = new Chart(title, height, (pen, width) => {
    const series = seriesOf();
    let top = 0;
    const all = [];
    series.forEach((one) => { for (const v of one.values) if (v === v) all.push(v); });
    all.sort((a, b) => a - b);
    // A few outliers must not compress the rest, so they are clipped.
    if (all.length) top = Math.min(all[all.length - 1], 2.5 * all[Math.floor(0.98 * (all.length - 1))]) * 1.05;
    // Angles have a sign, so their whole range is shown.
    if (chart.fromZero === null && all.length) top = all[all.length - 1] + 2;
    const low = chart.fromZero === null && all.length ? all[0] - 2 : chart.fromZero === false && all.length ? Math.max(0, all[Math.floor(0.02 * (all.length - 1))] * 0.85) : 0;
    const y = (v) => height - 2 - Math.min(1, Math.max(0, (v - low) / (top - low || 1))) * (height - 6);
    series.forEach((one) => drawSeries(pen, one, width, y));
    pen.fillStyle = dark() ? '#9aa6b5' : '#5b6675';
    pen.font = '11px system-ui, sans-serif';
    if (!all.length) { pen.fillText('nothing to show', 2, 11); return; }
    pen.textAlign = 'right';
    pen.fillText(human(top) + ' ' + unit, -6, 11);
    pen.fillText(human(low) + ' ' + unit, -6, height - 3);
    pen.textAlign = 'left';
    pen.fillRect(-2, 2, 1, height - 4);
  });
  return chart;
}

// Draws one value per pixel column: the largest of its frames.
function drawSeries(pen, one, width, y) {
  if (one.low && !one.thin) drawBand(pen, one, width, y);
  pen.strokeStyle = one.colour();
  pen.lineWidth = one.thin ? 0.8 : 1.4;
  pen.globalAlpha = one.thin ? 0.7 : 1;
  pen.beginPath();
  let drawing = false;
  const columns = Math.min(frameCount, Math.floor(width));
  for (let c = 0; c < columns; ++c) {
    let value = NaN;
    const end = Math.floor((c + 1) * frameCount / columns);
    for (let f = Math.floor(c * frameCount / columns); f < end; ++f) {
      if (one.values[f] === one.values[f] && !(value > one.values[f])) value = one.values[f];
    }
    if (value !== value) { drawing = false; continue; }
    const x = c / Math.max(1, columns - 1) * (width - 1);
    if (drawing) pen.lineTo(x, y(value)); else { pen.moveTo(x, y(value)); pen.lineTo(x + 0.5, y(value)); }
    drawing = true;
  }
  pen.stroke();
  pen.globalAlpha = 1;
}

// Draws a band from the lowest to the highest end of the intervals in each pixel
// column.
function drawBand(pen, one, width, y) {
  pen.fillStyle = one.colour();
  pen.globalAlpha = 0.22;
  const columns = Math.min(frameCount, Math.floor(width)), step = (width - 1) / Math.max(1, columns - 1);
  for (let c = 0; c < columns; ++c) {
    let low = Infinity, high = -Infinity;
    const end = Math.floor((c + 1) * frameCount / columns);
    for (let f = Math.floor(c * frameCount / columns); f < end; ++f) {
      if (one.low[f] < low) low = one.low[f];
      if (one.high[f] > high) high = one.high[f];
    }
    if (low <= high) pen.fillRect(c * step - step / 2, y(high), step, Math.max(1, y(low) - y(high)));
  }
  pen.globalAlpha = 1;
}

// Shows the colours of the first result; the other results have the same colours in
// thin lines.
function legend(chart, all) {
  const series = all.filter((one) => !one.thin);
  series.slice(0, 12).forEach((one) => {
    const line = element('i');
    line.style.background = one.colour();
    chart.head.append(element('span', { className: 'key' }, [line, one.name]));
  });
  if (series.length > 12) chart.head.append(element('span', { className: 'key', textContent: 'and ' + (series.length - 12) + ' more' }));
  const others = new Set(all.filter((one) => one.thin).map((one) => one.source));
  if (others.size) thinKey(chart, 'thin: ', others);
}

function thinKey(chart, prefix, names) {
  chart.head.append(element('span', { className: 'key', textContent: prefix + Array.from(names).join(', ') }));
}

// The person of a row, with the result's label if there are several results.
function rowName(row, letters) {
  const name = nameOf(row.result, row.person) + (results.length > 1 ? ' ' + row.result.label : '');
  return name.length > letters ? name.slice(0, letters - 1) + '\u2026' : name;
}

function presenceChart(drawMarks) {
  const rows = [];
  results.forEach((result) => result.ids.forEach((id, person) => rows.push({ result: result, person: person })));
  const most = 40, shown = rows.slice(0, most), rowHeight = shown.length > 16 ? 8 : 15;
  const mostViews = Math.max(1, ...results.map((result) => {
    let m = 1;
    for (const s of result.status) m = Math.max(m, s >> 2);
    return m;
  }));
  const chart = new Chart('Tracked people, by number of views', Math.max(1, shown.length) * rowHeight + 2, (pen, width) => {
    shown.forEach((row, i) => {
      pen.fillStyle = colourOf(row.result, row.person);
      const scale = width / frameCount;
      row.result.ofPerson[row.person].forEach((p) => {
        pen.globalAlpha = row.result.truth ? 0.5 : 0.2 + 0.8 * Math.min(1, meanViews(row.result, p) / mostViews);
        const h = row.result.index === 0 ? rowHeight - 3 : rowHeight * 0.45;
        const x = Math.floor(row.result.frame[p] * scale), end = Math.floor((row.result.frame[p] + 1) * scale);
        pen.fillRect(x, i * rowHeight + (rowHeight - h) / 2, Math.max(1, end - x), h);
      });
      pen.globalAlpha = 1;
      if (rowHeight < 12) return;
      pen.font = '11px system-ui, sans-serif';
      pen.textAlign = 'right';
      pen.fillStyle = dark() ? '#e7ebf0' : '#1b2430';
      pen.fillText(rowName(row, gutter() < 100 ? 9 : 18), -6, i * rowHeight + rowHeight - 4);
      pen.textAlign = 'left';
    });
    drawMarks(pen, width, shown, rowHeight);
  });
  chart.head.append(element('span', { className: 'key', textContent: 'full colour: ' + mostViews + ' views' + (results.some((result) => result.edits.length) ? '; diamonds: joined, cut, exchanged, undecided' : '') + (rows.length > most ? '; the first ' + most + ' of ' + rows.length : '') }));
  if (results.length > 1) thinKey(chart, 'thinner: ', results.slice(1).map((result) => result.label));
}

// `drawMarks` draws on the chart of presence.
export function makeCharts(drawMarks) {
  presenceChart(drawMarks);
  onFrame((f) => charts.forEach((chart) => chart.moveCursor(f)));
  const lead = results[0];
  if (lead.residual) {
    const series = residualSeries(lead);
    legend(lineChart('Residual per camera', 'px', 90, () => series), series);
  }
  const compared = results.filter((result) => result.difference);
  if (compared.length) {
    const series = [].concat(...compared.map((result) => perPerson(result, (p) => result.difference[p] === NO_VALUE ? NaN : result.difference[p] * 0.001 * LENGTH.per)));
    const name = results.some((result) => result.truth) ? 'the truth' : 'the first result (from the first: to the second result)';
    legend(lineChart('Distance to ' + name, LENGTH.unit, 80, () => series), series);
  }
  const speed = [].concat(...results.map((result) => perPerson(result, speedOf(result))));
  legend(lineChart('Mean speed of joints', SPEED.unit, 80, () => speed), speed);
  angleChart();
  if (lead.bones.length === 0) return;
  let bones = [];
  const choose = (b) => {
    const names = lead.bones[b].map((j) => lead.joints[j]);
    bones = [].concat(...results.map((result) => {
      const own = names.map((name) => result.joints.indexOf(name));
      return own.includes(-1) ? [] : perPerson(result, (p) => LENGTH.per * jointDistance(result, p, own[0], p, own[1]));
    }));
  };
  choose(0);
  const boneChart = lineChart('Bone length', LENGTH.unit, 80, () => bones);
  boneChart.fromZero = false;
  addChoice(boneChart, 'bone', 'Bone', lead.bones.map(([a, b], i) => [i, jointName(lead.joints[a]) + ' to ' + jointName(lead.joints[b])]), choose);
}

// A list in the head of a chart; a selection calls `choose(value)` and redraws.
function addChoice(chart, id, label, options, choose) {
  const select = element('select', { id: id });
  select.setAttribute('aria-label', label);
  options.forEach(([value, text]) => select.append(element('option', { value: value, textContent: text })));
  select.addEventListener('change', () => { choose(select.value); chart.draw(); });
  chart.head.append(select);
}

// One angle [degrees], with its interval if the page contains covariances.
function angleSeries(result, name) {
  const at = result.angles ? result.angles.names.indexOf(name) : -1;
  if (at < 0) return [];
  const listOf = (key) => {
    const texts = result.angles[key];
    return texts ? decode(texts[at], Int16Array) : null;
  };
  const degrees = (list) => (p) => list[p] === NO_ANGLE ? NaN : list[p] * result.angles.quantum;
  const series = perPerson(result, degrees(listOf('values')));
  const low = listOf('low'), high = listOf('high');
  if (low && high) {
    const lows = perPerson(result, degrees(low)), highs = perPerson(result, degrees(high));
    series.forEach((one, person) => { one.low = lows[person].values; one.high = highs[person].values; });
  }
  return series;
}

function angleChart() {
  const names = [];
  results.forEach((result) => (result.angles ? result.angles.names : []).forEach((name) => { if (!names.includes(name)) names.push(name); }));
  if (!names.length) return;
  let angles = [];
  const choose = (name) => { angles = [].concat(...results.map((result) => angleSeries(result, name))); };
  choose(names[0]);
  const chart = lineChart('Joint angle', '\u00b0', 90, () => angles);
  chart.fromZero = null;
  addChoice(chart, 'angle', 'Joint angle', names.map((name) => [name, jointName(name.replace(/^([lr]_[a-z]+)_/, '$1 '))]), choose);
  if (angles.some((one) => one.low)) chart.head.append(element('span', { className: 'key', textContent: 'bands: 95 % intervals' }));
}

// Name of the result to which distances of `result` are computed (ReferenceOf in
// page_data.cc).
export function referenceName(result) {
  if (results.some((one) => one.truth)) return 'the truth';
  return results[result.index === 0 ? 1 : 0].label;
}

// Distance from joint j of pose p to joint k of pose q; NaN if one is missing.
function jointDistance(result, p, j, q, k) {
  const J = result.joints.length, a = (p * J + j) * 3, b = (q * J + k) * 3, xyz = result.xyz;
  if ((result.status[p * J + j] & 3) === MISSING || (result.status[q * J + k] & 3) === MISSING) return NaN;
  return Math.hypot(xyz[a] - xyz[b], xyz[a + 1] - xyz[b + 1], xyz[a + 2] - xyz[b + 2]);
}

function perPerson(result, valueOf) {
  return result.ids.map((id, person) => {
    const values = new Float32Array(frameCount).fill(NaN);
    result.ofPerson[person].forEach((p, i) => { values[result.frame[p]] = valueOf(p, i, result.ofPerson[person]); });
    return { name: nameOf(result, person), colour: () => colourOf(result, person), values: values, thin: result.index > 0, source: result.label };
  });
}

function speedOf(result) {
  return (p, i, list) => {
    if (i === 0) return NaN;
    const q = list[i - 1], dt = times[result.frame[p]] - times[result.frame[q]];
    if (!(dt > 0) || dt > 0.25) return NaN;
    let sum = 0, n = 0;
    for (let j = 0; j < result.joints.length; ++j) {
      const distance = jointDistance(result, p, j, q, j);
      if (distance === distance) { sum += distance; ++n; }
    }
    return n ? SPEED.per * sum / n / dt : NaN;
  };
}

function meanViews(result, p) {
  const J = result.joints.length;
  let sum = 0, n = 0;
  for (let j = 0; j < J; ++j) {
    if ((result.status[p * J + j] & 3) !== MISSING) { sum += result.status[p * J + j] >> 2; ++n; }
  }
  return n ? sum / n : 0;
}

function residualSeries(result) {
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
