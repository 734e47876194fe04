// Images and videos behind the panels.
import { dark, decode, element, frameCount, frameNumbers, lastAtMost, times } from './data.js';
import { state } from './playback.js';

const KEPT_PICTURES = 24, AHEAD = 6;

function pictureUrl(pattern, number) {
  return fileUrl(pattern.replace(/%0?(\d*)d/, (all, width) => String(number).padStart(Number(width) || 0, '0')));
}

function fileUrl(path) { return path.split('/').map(encodeURIComponent).join('/'); }

// Source of the image of a frame: linked, or embedded. If the embedded image was
// left out, the latest one before it is used.
function pictureSource(panel, f) {
  const inside = panel.camera.pictures;
  if (!inside) return panel.camera.images ? pictureUrl(panel.camera.images, frameNumbers[f]) : undefined;
  const at = lastAtMost(inside.at, f);
  if (inside.at[at] > f) return undefined;
  const bytes = inside.base64[at];
  return 'data:image/' + (bytes.startsWith('/9j/') ? 'jpeg' : 'png') + ';base64,' + bytes;
}

// The image of a frame; undefined if there is none.
function pictureOf(panel, f) {
  if (f >= frameCount) return undefined;
  let picture = panel.pictures.get(f);
  if (picture) return picture;
  const source = pictureSource(panel, f);
  if (!source) return undefined;
  picture = new Image();
  picture.onload = picture.onerror = () => { if (state.frame === f) panel.redraw(f); };
  picture.src = source;
  panel.pictures.set(f, picture);
  if (panel.pictures.size > KEPT_PICTURES) panel.pictures.delete(panel.pictures.keys().next().value);
  return picture;
}

export function drawPicture(pen, panel, f) {
  const shown = panel.video ? videoOf(panel, f) : stillOf(panel, f);
  if (!shown) return;
  pen.drawImage(shown, 0, 0, panel.width, panel.height);
  // Dims the image, so that lines are visible on it.
  pen.fillStyle = dark() ? 'rgba(13,17,22,.35)' : 'rgba(255,255,255,.35)';
  pen.fillRect(0, 0, panel.width, panel.height);
}

function stillOf(panel, f) {
  const picture = pictureOf(panel, f);
  if (state.playing) for (let ahead = 1; ahead <= AHEAD; ++ahead) pictureOf(panel, f + ahead);
  if (!picture || !picture.complete) return undefined;
  if (picture.naturalWidth === 0) { panel.lacks = 'no image of this frame'; return undefined; }
  return picture;
}

// A playing video that is farther off than this [s] seeks its position; otherwise
// it plays faster or slower until it is in sync.
const FAR_APART = 0.3;

export function openVideo(panel) {
  const source = panel.camera.video;
  if (!source) return;
  const node = element('video', { muted: true, playsInline: true, preload: 'auto' });
  panel.video = { node: node, at: decode(source.at, Float64Array), sought: NaN };
  const redraw = () => panel.redraw(state.frame);
  ['loadedmetadata', 'loadeddata', 'seeked', 'error'].forEach((name) => node.addEventListener(name, redraw));
  // Browsers may report the end of a seek before the image is decoded.
  if (node.requestVideoFrameCallback) {
    const shown = () => { if (!state.playing) redraw(); node.requestVideoFrameCallback(shown); };
    node.requestVideoFrameCallback(shown);
  }
  node.src = source.data ? URL.createObjectURL(new Blob([decode(source.data, Uint8Array)], { type: source.type })) : fileUrl(source.source);
}

// The video element with the image of the frame; during a seek it still shows
// the previous one.
function videoOf(panel, f) {
  const node = panel.video.node;
  if (node.error) { panel.lacks = 'this browser does not play the video'; return undefined; }
  if (panel.video.at[f] < 0) { node.pause(); panel.lacks = 'no image of this frame'; return undefined; }
  if (node.readyState < 1) return undefined;
  if (state.playing) playAlong(panel.video, f);
  else seekVideo(panel.video, f);
  return node.readyState < 2 ? undefined : node;
}

// Seeks each position only once; otherwise a video that ends early would seek
// forever.
function seekVideo(video, f) {
  video.node.pause();
  const there = Math.abs(video.node.currentTime - video.at[f]) < 1e-3;
  if (there || video.node.seeking || video.sought === video.at[f]) return;
  video.sought = video.at[f];
  video.node.currentTime = video.at[f];
}

function playAlong(video, f) {
  const node = video.node, next = f + 1;
  const known = next < frameCount && video.at[next] >= 0 && times[next] > times[f];
  // Seconds of video per second of the recording, from this frame to the next.
  const slope = known ? (video.at[next] - video.at[f]) / (times[next] - times[f]) : 1;
  const behind = video.at[f] + (state.time - times[f]) * slope - node.currentTime;
  video.sought = NaN;
  if (Math.abs(behind) > FAR_APART && !node.seeking) node.currentTime += behind;
  const rate = state.speed * slope * (1 + Math.max(-0.5, Math.min(0.5, 3 * behind)));
  node.playbackRate = Math.max(0.0625, Math.min(16, rate));
  if (node.paused) node.play().catch(() => {});
}
