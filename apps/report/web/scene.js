// The 3D view, with names and cameras.
import { INFERRED, MISSING, OBSERVED, byId, colourOf, data, lastAtMost, nameOf, results, times } from './data.js';
import { state } from './playback.js';

export const up = new THREE.Vector3().fromArray(data.up);
export const scratch = {
  a: new THREE.Vector3(), b: new THREE.Vector3(), direction: new THREE.Vector3(),
  matrix: new THREE.Matrix4(), turn: new THREE.Quaternion(), scale: new THREE.Vector3(), y: new THREE.Vector3(0, 1, 0)
};

function extent() {
  const box = new THREE.Box3();
  results.forEach((result) => {
    const J = result.joints.length;
    const step = Math.max(1, Math.floor(result.frame.length / 3000));
    for (let p = 0; p < result.frame.length; p += step) {
      for (let j = 0; j < J; ++j) {
        if ((result.status[p * J + j] & 3) === MISSING) continue;
        box.expandByPoint(scratch.a.fromArray(result.xyz, (p * J + j) * 3));
      }
    }
  });
  if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  return box;
}
const people = extent();
const middle = people.getCenter(new THREE.Vector3());
export const reach = Math.min(30, Math.max(2, people.getSize(new THREE.Vector3()).length() / 2));

export class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    const context = canvas.getContext('webgl2', { antialias: true, alpha: true });
    if (!context) throw new Error('no WebGL 2');
    this.renderer = new THREE.WebGLRenderer({ canvas: canvas, context: context, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 500);
    this.camera.up.copy(up);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;
    this.controls.addEventListener('change', () => { this.dirty = true; });
    this.scene.add(new THREE.AmbientLight(0xffffff, 0.65));
    this.light = new THREE.DirectionalLight(0xffffff, 0.55);
    this.scene.add(this.light);
    this.ball = new THREE.IcosahedronBufferGeometry(1, 2);
    this.gem = new THREE.OctahedronBufferGeometry(1, 0);
    this.rod = new THREE.CylinderBufferGeometry(1, 1, 1, 8, 1, true);
    this.bodies = results.map(() => []);
    this.frusta = [];
    this.cameraLines = [];
    this.addFloor();
    this.addCameras();
    this.home();
    this.dirty = true;
  }

  home() {
    const right = new THREE.Vector3(1, 0, 0);
    if (Math.abs(up.x) > 0.9) right.set(0, 1, 0);
    const forward = new THREE.Vector3().crossVectors(up, right).normalize();
    right.crossVectors(forward, up).normalize();
    // Initial viewpoint: on the cameras' side; oblique to the axes if there are no
    // cameras or if these surround the people.
    const away = new THREE.Vector3();
    data.cameras.forEach((camera) => away.add(scratch.a.fromArray(camera.centre).sub(middle)));
    away.addScaledVector(up, -away.dot(up));
    if (away.length() < 0.3) away.copy(right).addScaledVector(forward, 0.6);
    away.normalize();
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(away, reach * 1.9).addScaledVector(up, reach * 1.05);
    this.controls.update();
  }

  addFloor() {
    const size = Math.ceil(reach * 1.6) * 2;
    this.floor = new THREE.GridHelper(size, size, 0x8090a0, 0x8090a0);
    this.floor.material.transparent = true;
    this.floor.material.opacity = 0.32;
    this.floor.material.depthWrite = false;
    this.floor.quaternion.setFromUnitVectors(scratch.y, up);
    this.floor.position.copy(middle).addScaledVector(up, data.floor - middle.dot(up));
    this.scene.add(this.floor);
  }

  addCameras() {
    this.cameraGroup = new THREE.Group();
    this.cameraMaterial = new THREE.LineBasicMaterial({ color: 0x7b8794 });
    const depth = Math.min(0.6, reach * 0.12);
    data.cameras.forEach((camera) => {
      const width = camera.width || 2 * camera.K[2], height = camera.height || 2 * camera.K[5];
      const corner = (u, v) => {
        const x = (u - camera.K[2]) / camera.K[0] * depth, y = (v - camera.K[5]) / camera.K[4] * depth;
        const c = [x - camera.t[0], y - camera.t[1], depth - camera.t[2]], R = camera.R;
        return new THREE.Vector3(R[0] * c[0] + R[3] * c[1] + R[6] * c[2], R[1] * c[0] + R[4] * c[1] + R[7] * c[2], R[2] * c[0] + R[5] * c[1] + R[8] * c[2]);
      };
      const apex = new THREE.Vector3().fromArray(camera.centre);
      const corners = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)];
      const points = [];
      corners.forEach((c, i) => {
        points.push(apex, c, c, corners[(i + 1) % 4]);
        this.cameraLines.push([apex, c], [c, corners[(i + 1) % 4]]);
      });
      this.cameraGroup.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), this.cameraMaterial));
      this.frusta.push(apex);
    });
    this.scene.add(this.cameraGroup);
  }

  // Meshes of one person: joints and bones, observed and inferred separately.
  body(result, person) {
    const made = this.bodies[result.index];
    if (made[person]) return made[person];
    const solid = new THREE.MeshLambertMaterial({ color: colourOf(result, person) });
    const faint = new THREE.MeshLambertMaterial({ color: colourOf(result, person), transparent: true, opacity: 0.3, depthWrite: false });
    const shape = result.index === 0 ? this.ball : this.gem;
    const mesh = (shared, material, count) => {
      // three.js draws two successive meshes with one geometry at the position of
      // the first, so each has a geometry of its own with shared buffers.
      const geometry = new THREE.BufferGeometry();
      geometry.index = shared.index;
      Object.assign(geometry.attributes, shared.attributes);
      const instanced = new THREE.InstancedMesh(geometry, material, Math.max(1, count));
      instanced.frustumCulled = false;
      this.scene.add(instanced);
      return instanced;
    };
    const J = result.joints.length, B = result.bones.length;
    const body = {
      solid: solid, faint: faint,
      joints: mesh(shape, solid, J), inferredJoints: mesh(shape, faint, J),
      bones: mesh(this.rod, solid, B), inferredBones: mesh(this.rod, faint, B), ellipsoids: null
    };
    const trail = new THREE.BufferGeometry();
    trail.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * TRAIL_POINTS), 3));
    body.trailMaterial = new THREE.LineBasicMaterial({ color: colourOf(result, person), transparent: true, opacity: 0.7 });
    body.trail = new THREE.Line(trail, body.trailMaterial);
    body.trail.frustumCulled = false;
    this.scene.add(body.trail);
    body.meshes = [body.joints, body.inferredJoints, body.bones, body.inferredBones];
    made[person] = body;
    return body;
  }

  hideBody(body) {
    body.meshes.forEach((mesh) => { mesh.visible = false; });
    body.trail.visible = false;
    if (body.ellipsoids) body.ellipsoids.visible = false;
  }

  poseBody(result, p) {
    const body = this.body(result, result.person[p]);
    const J = result.joints.length, xyz = result.xyz, base = p * J;
    const thickness = result.index === 0 ? 1 : 0.45;
    let observed = 0, inferred = 0;
    for (let j = 0; j < J; ++j) {
      const status = result.status[base + j] & 3;
      if (status === MISSING) continue;
      const size = (result.index === 0 ? 0.032 : 0.026) * (status === INFERRED ? 0.8 : 1);
      scratch.matrix.makeScale(size, size, size).setPosition(xyz[(base + j) * 3], xyz[(base + j) * 3 + 1], xyz[(base + j) * 3 + 2]);
      if (status === OBSERVED) body.joints.setMatrixAt(observed++, scratch.matrix);
      else body.inferredJoints.setMatrixAt(inferred++, scratch.matrix);
    }
    body.joints.count = observed;
    body.inferredJoints.count = inferred;
    observed = inferred = 0;
    for (const [a, b] of result.bones) {
      const status = Math.min(result.status[base + a] & 3, result.status[base + b] & 3);
      if (status === MISSING) continue;
      scratch.a.fromArray(xyz, (base + a) * 3);
      scratch.b.fromArray(xyz, (base + b) * 3);
      const length = scratch.direction.subVectors(scratch.b, scratch.a).length();
      if (length < 1e-6) continue;
      scratch.turn.setFromUnitVectors(scratch.y, scratch.direction.divideScalar(length));
      scratch.a.add(scratch.b).multiplyScalar(0.5);
      scratch.matrix.compose(scratch.a, scratch.turn, scratch.scale.set(0.019 * thickness, length, 0.019 * thickness));
      if (status === OBSERVED) body.bones.setMatrixAt(observed++, scratch.matrix);
      else body.inferredBones.setMatrixAt(inferred++, scratch.matrix);
    }
    body.bones.count = observed;
    body.inferredBones.count = inferred;
    body.meshes.forEach((mesh) => { mesh.visible = mesh.count > 0; mesh.instanceMatrix.needsUpdate = true; });
    this.poseTrail(result, p, body);
    this.poseEllipsoids(result, p, body);
  }

  poseTrail(result, p, body) {
    body.trail.visible = show.trails;
    if (!show.trails) return;
    const history = result.ofPerson[result.person[p]];
    const position = body.trail.geometry.attributes.position;
    let at = lastAtMost(history, p), count = 0;
    const last = times[result.frame[p]];
    for (; at >= 0 && count < TRAIL_POINTS && last - times[result.frame[history[at]]] < TRAIL_SECONDS; --at) {
      const c = footOf(result, history[at]);
      if (!c) continue;
      position.array.set(c, 3 * count++);
    }
    body.trail.geometry.setDrawRange(0, count);
    position.needsUpdate = true;
  }

  poseEllipsoids(result, p, body) {
    const wanted = show.ellipsoids && result.covariance && result.extra[p] >= 0;
    if (!wanted) {
      if (body.ellipsoids) body.ellipsoids.visible = false;
      return;
    }
    const J = result.joints.length;
    if (!body.ellipsoids) {
      const material = new THREE.MeshLambertMaterial({ color: colourOf(result, result.person[p]), transparent: true, opacity: 0.28, depthWrite: false });
      body.ellipsoids = new THREE.InstancedMesh(this.ball, material, J);
      body.ellipsoids.frustumCulled = false;
      this.scene.add(body.ellipsoids);
    }
    let count = 0;
    for (let j = 0; j < J; ++j) {
      if ((result.status[p * J + j] & 3) === MISSING) continue;
      const at = (result.extra[p] * J + j) * 6, L = result.covariance, k = 2 * result.rootQuantum;
      if (L[at] === 0 && L[at + 2] === 0) continue;
      const x = (p * J + j) * 3;
      scratch.matrix.set(
        k * L[at], 0, 0, result.xyz[x],
        k * L[at + 1], k * L[at + 2], 0, result.xyz[x + 1],
        k * L[at + 3], k * L[at + 4], k * L[at + 5], result.xyz[x + 2], 0, 0, 0, 1);
      body.ellipsoids.setMatrixAt(count++, scratch.matrix);
    }
    body.ellipsoids.count = count;
    body.ellipsoids.visible = count > 0;
    body.ellipsoids.instanceMatrix.needsUpdate = true;
  }

  setFrame(f) {
    this.bodies.forEach((made) => made.forEach((body) => body && this.hideBody(body)));
    results.forEach((result) => {
      if (!result.visible) return;
      for (let p = result.start[f]; p < result.start[f + 1]; ++p) this.poseBody(result, p);
    });
    this.floor.visible = show.floor;
    this.cameraGroup.visible = show.cameras;
    this.dirty = true;
  }

  recolour() {
    this.bodies.forEach((made, r) => made.forEach((body, person) => {
      if (!body) return;
      const colour = colourOf(results[r], person);
      [body.solid, body.faint, body.trailMaterial].forEach((material) => material.color.set(colour));
    }));
    this.dirty = true;
  }

  resize() {
    // Stored, because querying the size forces the browser to compute the layout.
    this.width = this.canvas.parentElement.clientWidth;
    this.height = this.canvas.parentElement.clientHeight;
    this.renderer.setSize(this.width, this.height, false);
    this.camera.aspect = this.width / Math.max(1, this.height);
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  render() {
    if (!this.dirty) return;
    this.dirty = false;
    this.light.position.copy(this.camera.position).addScaledVector(up, reach);
    this.renderer.render(this.scene, this.camera);
    placeLabels(this);
  }
}

const TRAIL_POINTS = 128, TRAIL_SECONDS = 2;
export const show = { trails: true, labels: true, cameras: true, floor: true, ellipsoids: false };

// Position of a person on the floor: the mean of the joints, projected vertically
// to 1 cm above the floor.
const footBuffer = [0, 0, 0];
function footOf(result, p) {
  const J = result.joints.length;
  let x = 0, y = 0, z = 0, n = 0;
  for (let j = 0; j < J; ++j) {
    if ((result.status[p * J + j] & 3) === MISSING) continue;
    const at = (p * J + j) * 3;
    x += result.xyz[at]; y += result.xyz[at + 1]; z += result.xyz[at + 2];
    ++n;
  }
  if (n === 0) return null;
  x /= n; y /= n; z /= n;
  const drop = data.floor + 0.01 - (x * up.x + y * up.y + z * up.z);
  footBuffer[0] = x + drop * up.x; footBuffer[1] = y + drop * up.y; footBuffer[2] = z + drop * up.z;
  return footBuffer;
}

const labelPool = [];
function placeLabels(view) {
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
