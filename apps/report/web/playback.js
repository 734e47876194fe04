// The displayed frame, and playback.
import { byId, frameCount, frameNumbers, times } from './data.js';

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
export const state = { frame: 0, playing: false, speed: 1, time: times[0] || 0, lastTick: 0, pictures: 0, scene: null };

// Listeners: `draw(f)` when the frame or its display changes, `stop(f)` at each pause.
const drawings = [];
export function onFrame(draw, stop) { drawings.push({ draw: draw, stop: stop || (() => {}) }); }

export function setFrame(f) {
  state.frame = Math.max(0, Math.min(frameCount - 1, f));
  state.time = times[state.frame];
  update();
}

export function update() {
  const f = state.frame;
  drawings.forEach((one) => one.draw(f));
  byId('scrub').value = f;
  byId('clock').textContent = 'frame ' + frameNumbers[f] + ' \u00b7 ' + times[f].toFixed(2) + ' s';
}

export function play() {
  if (state.frame >= frameCount - 1) setFrame(0);
  state.playing = true;
  state.lastTick = 0;
  byId('play').textContent = 'Pause';
}
export function pause() {
  state.playing = false;
  byId('play').textContent = 'Play';
  drawings.forEach((one) => one.stop(state.frame));
}

export function tick(now) {
  if (state.playing) {
    const elapsed = state.lastTick ? Math.min(0.25, (now - state.lastTick) / 1000) : 0;
    state.lastTick = now;
    const target = state.time + elapsed * state.speed;
    let f = state.frame;
    while (f < frameCount - 1 && times[f + 1] <= target) ++f;
    const moved = f !== state.frame;
    state.frame = f;
    state.time = target;
    if (moved) update();
    if (f >= frameCount - 1) pause();
  }
  if (state.scene) state.scene.render();
  ++state.pictures;
  window.requestAnimationFrame(tick);
}

function changeSpeed(step) {
  const at = Math.max(0, Math.min(SPEEDS.length - 1, SPEEDS.indexOf(state.speed) + step));
  state.speed = SPEEDS[at];
  byId('speed').value = String(state.speed);
}

export function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const tag = event.target.tagName;
  if (tag === 'SELECT' || (tag === 'BUTTON' && (event.key === ' ' || event.key === 'Enter'))) return;
  const stride = event.shiftKey ? 10 : 1;
  const actions = {
    ' ': () => (state.playing ? pause() : play()),
    ArrowLeft: () => { pause(); setFrame(state.frame - stride); },
    ArrowRight: () => { pause(); setFrame(state.frame + stride); },
    Home: () => { pause(); setFrame(0); },
    End: () => { pause(); setFrame(frameCount - 1); },
    '+': () => changeSpeed(1), '=': () => changeSpeed(1), '-': () => changeSpeed(-1)
  };
  if (!Object.prototype.hasOwnProperty.call(actions, event.key)) return;
  event.preventDefault();
  actions[event.key]();
}
